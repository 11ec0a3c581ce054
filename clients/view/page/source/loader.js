// SPDX-License-Identifier: GPL-3.0-or-later
// Fetches the meshes that a scene names.

import { read_eye } from "./eye.js";

async function fetch_eye(path) {
  const reply = await fetch(path);
  if (!reply.ok) throw new Error(`${path}: the bridge says ${reply.status}`);
  return read_eye(await reply.arrayBuffer());
}

/** {objects: [eye or null, by index], tool: eye or null, troubles: [text]}. */
export async function load_eyes(scene) {
  const troubles = [];
  const load = (path) =>
    path
      ? fetch_eye(path).catch((error) => {
          troubles.push(`A mesh cannot be shown: ${error.message}`);
          return null;
        })
      : Promise.resolve(null);
  const objects = [];
  const wanted = (scene.objects ?? []).map(async ({ index, mesh }) => {
    objects[index] = await load(mesh);
  });
  const [tool] = await Promise.all([load(scene.tool?.mesh), ...wanted]);
  return { objects: Array.from(objects, (eye) => eye ?? null), tool, troubles };
}

/** What the pictures depend on; of equal text no mesh need be loaded again. */
export function picture_key(scene) {
  return JSON.stringify([scene.session, scene.objects, scene.tool, scene.limits]);
}

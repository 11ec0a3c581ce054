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

/** The same of the convex pieces that a scene names, which are fetched where somebody wants to see
 *  them. */
export function load_pieces(scene) {
  return load_eyes({
    objects: (scene.objects ?? []).map(({ index, pieces }) => ({ index, mesh: pieces })),
    tool: { mesh: scene.tool?.pieces },
  });
}

/** Whether the scene has pieces of anything. */
export function has_pieces(scene) {
  return Boolean(scene.tool?.pieces) || (scene.objects ?? []).some(({ pieces }) => pieces);
}

/** What the pictures depend on; of equal text no mesh need be loaded again. */
export function picture_key(scene) {
  return JSON.stringify([scene.session, scene.objects, scene.tool, scene.limits]);
}

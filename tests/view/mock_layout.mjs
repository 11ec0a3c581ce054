// SPDX-License-Identifier: GPL-3.0-or-later
// The layout of docs/view-protocol.md, and a writer of frames, written apart from the page's reader.

const kFixed = `sequence column tick time realtime tool:7 proxy:7 verified:7 handle:7 velocity:6 force:3
  torque:3 coupling_force:3 coupling_torque:3 depth fade flags fault renderer solver skipped wake_late busy
  n_pushing contact_age contact_flags contact_renderer reseeds contact_busy age_servo age_contact age_sim
  rate_servo rate_contact rate_sim unseen lost revision stiffness damping rotational_stiffness
  rotational_damping paused armed leading intent:3 buttons n_objects n_listed n_joints n_samples`;
const kObject = "pose:7";
const kContact = "point:3 normal:3 extent stiffness object active kind";
const kJoint = "position velocity";
const kSample = "time force:3 torque:3 depth wake_late contact_rate flags";

function places(text) {
  const table = {};
  let offset = 0;
  for (const word of text.trim().split(/\s+/)) {
    const [name, count = "1"] = word.split(":");
    table[name] = [offset, Number(count)];
    offset += Number(count);
  }
  return [table, offset];
}

const with_size = (text) => {
  const [table, size] = places(text);
  return { size, ...table };
};

export function make_layout() {
  const [fixed, fixed_size] = places(kFixed);
  return {
    fixed,
    fixed_size,
    object: with_size(kObject),
    contact: with_size(kContact),
    joint: with_size(kJoint),
    sample: with_size(kSample),
  };
}

/** Bytes of a frame {fixed fields, objects: [], contacts: [], joints: [], samples: []}; what is missing is 0. */
export function encode(layout, frame) {
  const numbers = [];
  const put = (table, record) => {
    for (const [name, place] of Object.entries(table)) {
      if (!Array.isArray(place)) continue;
      const value = record[name] ?? (place[1] === 1 ? 0 : new Array(place[1]).fill(0));
      numbers.push(...(place[1] === 1 ? [value] : value));
    }
  };
  put(layout.fixed, {
    ...frame,
    n_objects: frame.objects.length,
    n_listed: frame.contacts.length,
    n_joints: frame.joints?.length ?? 0,
    n_samples: frame.samples.length,
  });
  for (const object of frame.objects) put(layout.object, object);
  for (const contact of frame.contacts) put(layout.contact, contact);
  for (const joint of frame.joints ?? []) put(layout.joint, joint);
  for (const sample of frame.samples) put(layout.sample, sample);
  return Float64Array.from(numbers);
}

/** Bytes of an eye file. */
export function encode_eye({ name, object, colour, vertices, normals, triangles, points = [] }) {
  const bytes = Buffer.alloc(
    80 + 4 * (vertices.length + normals.length + triangles.length + points.length),
  );
  bytes.write("HAPTEYE1", 0, "latin1");
  bytes.writeUInt32LE(vertices.length / 3, 8);
  bytes.writeUInt32LE(triangles.length / 3, 12);
  bytes.writeUInt32LE(points.length / 3, 16);
  bytes.writeUInt32LE(object, 20);
  colour.forEach((value, i) => bytes.writeFloatLE(value, 24 + 4 * i));
  bytes.write(name, 40, 40, "utf8");
  let at = 80;
  for (const value of [...vertices, ...normals]) at = bytes.writeFloatLE(value, at);
  for (const value of triangles) at = bytes.writeUInt32LE(value, at);
  for (const value of points) at = bytes.writeFloatLE(value, at);
  return bytes;
}

/** An octahedron of `radius` as an eye of eight convex pieces, a tetrahedron each. */
export function octants(name, object, radius) {
  const [vertices, normals, triangles] = [[], [], []];
  for (let piece = 0; piece < 8; piece += 1) {
    const sign = [1, 2, 4].map((bit) => (piece & bit ? -1 : 1));
    const corners = [0, 1, 2].map((axis) => [0, 1, 2].map((k) => (k === axis ? sign[k] * radius : 0)));
    const [a, b, c, d] = [0, 1, 2, 3].map((k) => 4 * piece + k);
    vertices.push(0, 0, 0, ...corners.flat());
    normals.push(...Array.from({ length: 4 }, () => sign.map((s) => s / Math.sqrt(3))).flat());
    const turned = sign[0] * sign[1] * sign[2] < 0;
    for (const [u, v, w] of [[b, c, d], [a, c, b], [a, d, c], [a, b, d]])
      triangles.push(...(turned ? [u, w, v] : [u, v, w]));
  }
  return encode_eye({ name, object, colour: [1, 1, 1, 1], vertices, normals, triangles });
}

/** A ball of `radius` as an eye. */
export function ball(name, object, colour, radius, rings, shell = 0) {
  const [vertices, normals, triangles, points] = [[], [], [], []];
  for (let i = 0; i <= rings; i += 1) {
    for (let j = 0; j <= 2 * rings; j += 1) {
      const [theta, phi] = [(Math.PI * i) / rings, (Math.PI * j) / rings];
      const n = [Math.sin(theta) * Math.cos(phi), Math.cos(theta), Math.sin(theta) * Math.sin(phi)];
      normals.push(...n);
      vertices.push(...n.map((value) => value * radius));
      if (i === rings || j === 2 * rings) continue;
      const [a, b] = [i * (2 * rings + 1) + j, (i + 1) * (2 * rings + 1) + j];
      triangles.push(a, a + 1, b, a + 1, b + 1, b);
    }
  }
  for (let i = 0; i < shell; i += 1) {
    const y = 1 - (2 * (i + 0.5)) / shell;
    const [r, turn] = [Math.sqrt(1 - y * y), i * 2.399963];
    points.push(...[r * Math.cos(turn), y, r * Math.sin(turn)].map((value) => value * radius));
  }
  return encode_eye({ name, object, colour, vertices, normals, triangles, points });
}

/** Bytes of a drawing {points: [{p, radius, colour}], lines: [{from, to, colour}]}; colours 0xRRGGBB. */
export function encode_drawing({ points = [], lines = [] }) {
  const head = new Uint8Array(16);
  head.set(new TextEncoder().encode("HAPTDRW1"));
  new DataView(head.buffer).setUint32(8, points.length, true);
  new DataView(head.buffer).setUint32(12, lines.length, true);
  const places = points.flatMap(({ p, radius }) => [...p, radius]);
  const ends = lines.flatMap(({ from, to }) => [...from, ...to]);
  const parts = (colour) => [colour >> 16, (colour >> 8) & 255, colour & 255, 255];
  return Buffer.concat([
    head,
    Buffer.from(new Float32Array(places).buffer),
    Buffer.from(new Float32Array(ends).buffer),
    Buffer.from(points.flatMap(({ colour }) => parts(colour))),
    Buffer.from(lines.flatMap(({ colour }) => [...parts(colour), ...parts(colour)])),
  ]);
}

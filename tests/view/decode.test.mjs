// SPDX-License-Identifier: GPL-3.0-or-later
import assert from "node:assert/strict";
import { test } from "node:test";
import { pieces_of, read_eye } from "../../clients/view/page/source/eye.js";
import { decode_frame, each_sample, kQuantities } from "../../clients/view/page/source/layout.js";
import { tables_of } from "../../clients/view/page/source/overview.js";
import { encode, encode_eye, make_layout, octants } from "./mock_layout.mjs";

const layout = make_layout();
const sample = (time, force) => ({
  time,
  force,
  torque: [0, 0.003, 0.004],
  depth: 0.001,
  wake_late: 2e-5,
  contact_rate: 900,
  flags: 1,
});
const frame = {
  sequence: 7,
  tick: 2 ** 52 + 1,
  tool: [1, 2, 3, 1, 0, 0, 0],
  n_pushing: 1,
  objects: [{ pose: [4, 5, 6, 0, 1, 0, 0] }],
  joints: [{ position: 0.5, velocity: -2 }],
  samples: [sample(1, [3, 4, 0]), sample(1.001, [0, 0, -2])],
  contacts: [
    {
      point: [7, 8, 9],
      normal: [0, 1, 0],
      extent: 0.01,
      stiffness: 5,
      object: 0,
      active: 1,
      kind: 2,
    },
  ],
};

test("a frame is read by the places of the layout, ticks beyond 2^52 exactly", () => {
  const read = decode_frame(encode(layout, frame).buffer, layout);
  assert.equal(read.sequence, 7);
  assert.equal(read.tick, 2 ** 52 + 1);
  assert.deepEqual([...read.tool], frame.tool);
  assert.deepEqual([...read.objects[0].pose], frame.objects[0].pose);
  assert.deepEqual([...read.contacts[0].point], [7, 8, 9]);
  assert.equal(read.contacts[0].kind, 2);
  assert.deepEqual(read.joints, [{ position: 0.5, velocity: -2 }]);
});

test("a layout in another order is followed, for the page knows none", () => {
  const other = make_layout();
  const names = Object.keys(other.fixed).reverse();
  let offset = 0;
  for (const name of names) {
    other.fixed[name] = [offset, other.fixed[name][1]];
    offset += other.fixed[name][1];
  }
  const read = decode_frame(encode_shuffled(other).buffer, other);
  assert.equal(read.tick, 41);
  assert.deepEqual([...read.force], [1, 2, 3]);
});

function encode_shuffled(other) {
  const numbers = new Float64Array(other.fixed_size);
  numbers[other.fixed.tick[0]] = 41;
  numbers.set([1, 2, 3], other.fixed.force[0]);
  return numbers;
}

test("each packed sample has its norms and is handed on once", () => {
  const read = decode_frame(encode(layout, frame).buffer, layout);
  const rows = [];
  each_sample(read.samples, layout.sample, (time, values) => rows.push([time, ...values]));
  assert.equal(rows.length, 2);
  const at = (row, name) => row[1 + kQuantities.indexOf(name)];
  assert.equal(at(rows[0], "force"), 5);
  assert.equal(at(rows[1], "force_z"), -2);
  assert.ok(Math.abs(at(rows[0], "torque") - 0.005) < 1e-15);
  assert.equal(at(rows[0], "contact_rate"), 900);
  assert.equal(rows[1][0], 1.001);
});

test("a frame that is cut off, or whose counts lie, is refused", () => {
  const bytes = encode(layout, frame).buffer;
  assert.throws(() => decode_frame(bytes.slice(0, 100), layout), RangeError);
  assert.throws(() => decode_frame(bytes.slice(0, -8), layout), RangeError);
  const lying = encode(layout, frame);
  lying[layout.fixed.n_samples[0]] = 3;
  assert.throws(() => decode_frame(lying.buffer, layout), RangeError);
});

const bytes_of = (buffer) =>
  buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.byteLength);
const triangle = {
  name: "Schädel",
  object: 3,
  colour: [1, 0.5, 0.25, 1],
  vertices: [0, 0, 0, 1, 0, 0, 0, 1, 0],
  normals: [0, 0, 1, 0, 0, 1, 0, 0, 1],
  triangles: [0, 1, 2],
  points: [5, 6, 7],
};

test("an eye file is read", () => {
  const eye = read_eye(bytes_of(encode_eye(triangle)));
  assert.equal(eye.name, "Schädel");
  assert.equal(eye.object, 3);
  assert.deepEqual(eye.colour, [1, 0.5, 0.25, 1]);
  assert.deepEqual([...eye.triangles], [0, 1, 2]);
  assert.deepEqual([...eye.points], [5, 6, 7]);
});

test("an eye file with a wrong beginning, length or index is refused", () => {
  const good = encode_eye(triangle);
  const bad = Buffer.from(good);
  bad.write("X", 0);
  assert.throws(() => read_eye(bytes_of(bad)), /HAPTEYE1/);
  assert.throws(() => read_eye(bytes_of(good.subarray(0, good.length - 4))), /bytes/);
  assert.throws(() => read_eye(new ArrayBuffer(10)), /header/);
  assert.throws(
    () => read_eye(bytes_of(encode_eye({ ...triangle, triangles: [0, 1, 3] }))),
    /vertex/,
  );
});

test("an overview has two points for each step: the least and the greatest", () => {
  const [table] = tables_of({
    time: [10, 12],
    columns: [{ name: "a", depth: { min: [1, null], max: [2, null] } }],
  });
  assert.deepEqual(table[0], [10, 11, 12, 13]);
  assert.deepEqual(table[1 + kQuantities.indexOf("depth")], [1, 2, null, null]);
  assert.deepEqual(table[1], [null, null, null, null]);
});

test("pieces of an eye file are what triangles connect, in the order of the vertices", () => {
  const eye = read_eye(new Uint8Array(octants("ball", 0, 1)).buffer);
  assert.equal(eye.triangles.length, 3 * 4 * 8);
  assert.deepEqual(
    [...pieces_of(eye)],
    Array.from({ length: 32 }, (_, vertex) => Math.floor(vertex / 4)),
  );
  // a chain whose ends meet last, and a vertex that nothing uses
  const chain = { vertices: new Float32Array(3 * 8), triangles: Uint32Array.of(0, 1, 2, 4, 5, 6, 2, 6, 1) };
  assert.deepEqual([...pieces_of(chain)], [0, 0, 0, 1, 0, 0, 0, 2]);
});

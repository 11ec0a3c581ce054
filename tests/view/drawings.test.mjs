// SPDX-License-Identifier: GPL-3.0-or-later
// What the page does with what clients draw, without a browser.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Drawings, read_drawing } from "../../clients/view/page/source/drawings.js";
import { encode_drawing } from "./mock_layout.mjs";

const dot = (x) => ({ p: [x, 2, 3], radius: 0.5, colour: 0x102030 });
const bytes_of = (drawing) => Uint8Array.from(encode_drawing(drawing)).buffer;
const turn = () => new Promise((done) => setImmediate(done));

test("a drawing is read as it was written", () => {
  const lines = [{ from: [1, 2, 3], to: [4, 5, 6], colour: 0xa0b0c0 }];
  const drawing = read_drawing(bytes_of({ points: [dot(1), dot(7)], lines }));
  assert.deepEqual([...drawing.places], [1, 2, 3, 0.5, 7, 2, 3, 0.5]);
  assert.deepEqual([...drawing.colours], [16, 32, 48, 255, 16, 32, 48, 255]);
  assert.deepEqual([...drawing.lines], [1, 2, 3, 4, 5, 6]);
  assert.deepEqual([...drawing.line_colours], [160, 176, 192, 255, 160, 176, 192, 255]);
  assert.equal(read_drawing(bytes_of({})).places.length, 0);
});

test("bytes that are no drawing are refused", () => {
  const good = bytes_of({ points: [dot(1)] });
  for (const bytes of [good.slice(0, -1), good.slice(0, 12), new ArrayBuffer(0), new ArrayBuffer(99)])
    assert.throws(() => read_drawing(bytes), RangeError);
  const many = good.slice(0);
  new DataView(many).setUint32(8, 0xffffffff, true);
  assert.throws(() => read_drawing(many), RangeError);
});

/** A page without a browser: its fetches are answered by hand. */
function page_of() {
  const shown = [];
  const asked = [];
  const troubles = [];
  globalThis.document = { hidden: false };
  globalThis.fetch = (path) =>
    new Promise((answer) => {
      asked.push({ path, give: (buffer) => answer({ ok: true, arrayBuffer: async () => buffer }), lack: () => answer({ ok: false }) });
    });
  const drawings = new Drawings({
    show: (client, drawing) => shown.push([client, drawing && drawing.places[0]]),
    trouble: (text) => troubles.push(text),
  });
  const say = (...numbers) =>
    drawings.take({
      drawings: Object.entries(Object.assign({}, ...numbers)).map(([client, number]) => ({
        client: Number(client),
        number,
        path: `/drawn/${client}.bin`,
      })),
    });
  return { shown, asked, troubles, drawings, say };
}

test("each client is fetched once at a time, and the newest next", async () => {
  const { shown, asked, say } = page_of();
  say({ 0: "1.1" });
  say({ 0: "1.2" });
  say({ 0: "1.3" }, { 5: "2.1" });
  assert.deepEqual(asked.map(({ path }) => path), ["/drawn/0.bin", "/drawn/5.bin"]);
  asked[0].give(bytes_of({ points: [dot(3)] }));
  await turn();
  assert.deepEqual(shown, [[0, 3]]);
  assert.equal(asked.length, 3, "that of the newest number");
  asked[2].give(bytes_of({ points: [dot(4)] }));
  await turn();
  say({ 0: "1.3" }, { 5: "2.1" });
  await turn();
  assert.deepEqual(shown, [[0, 3], [0, 4]]);
  assert.equal(asked.length, 3, "what is shown is not fetched again");
});

test("who leaves takes the drawing along, also one that is under way", async () => {
  const { shown, asked, say } = page_of();
  say({ 1: "1.1" }, { 2: "1.1" });
  asked[0].give(bytes_of({ points: [dot(1)] }));
  await turn();
  say();
  asked[1].give(bytes_of({ points: [dot(2)] }));
  await turn();
  assert.deepEqual(shown, [[1, 1], [1, null]]);
  // and comes again
  say({ 1: "2.1" });
  assert.equal(asked.length, 3);
});

test("what is not there any more, or is broken, is left out; a hidden page asks for nothing", async () => {
  const { shown, asked, troubles, drawings, say } = page_of();
  say({ 1: "1.1" });
  asked[0].lack();
  await turn();
  assert.deepEqual([shown, troubles], [[], []]);
  say({ 1: "1.2" });
  asked[1].give(new ArrayBuffer(5));
  await turn();
  assert.deepEqual(troubles, ["A drawing cannot be shown: these bytes are no drawing"]);
  globalThis.document.hidden = true;
  say({ 1: "1.3" });
  assert.equal(asked.length, 2);
  globalThis.document.hidden = false;
  drawings.load();
  assert.equal(asked.length, 3);
});

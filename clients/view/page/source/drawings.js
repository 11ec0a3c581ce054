// SPDX-License-Identifier: GPL-3.0-or-later
// Fetches what clients draw, when the bridge says that it is another one.

const kMagic = "HAPTDRW1";
const kHeader = 16; // [bytes]

/** {places: x y z radius of each point, lines: from and to, and the colours of both as bytes}, as they
 *  lie in the buffer. Throws a RangeError where the length does not fit. */
export function read_drawing(buffer) {
  const view = new DataView(buffer);
  const magic = buffer.byteLength < kHeader ? "" : String.fromCharCode(...new Uint8Array(buffer, 0, 8));
  if (magic !== kMagic) throw new RangeError("these bytes are no drawing");
  const [n_points, n_lines] = [view.getUint32(8, true), view.getUint32(12, true)];
  let at = kHeader;
  const next = (Kind, count) => {
    const array = new Kind(buffer, at, count);
    at += array.byteLength;
    return array;
  };
  const drawing = {
    places: next(Float32Array, 4 * n_points),
    lines: next(Float32Array, 6 * n_lines),
    colours: next(Uint8Array, 4 * n_points),
    line_colours: next(Uint8Array, 8 * n_lines),
  };
  if (at !== buffer.byteLength) throw new RangeError(`a drawing of ${buffer.byteLength} bytes, not ${at}`);
  return drawing;
}

/** One fetch of each client is under way at a time, and the newest drawing is fetched next. */
export class Drawings {
  /** `show(client, drawing or null)`, `trouble(text)`. */
  constructor({ show, trouble }) {
    this.show = show;
    this.trouble = trouble;
    this.wanted = new Map(); // by client: what the bridge has
    this.shown = new Map(); // its number
    this.busy = new Set();
  }

  /** Takes a message `drawings` of the bridge. */
  take({ drawings }) {
    this.wanted = new Map(drawings.map((one) => [one.client, one]));
    for (const client of this.shown.keys()) {
      if (!this.wanted.has(client)) this.forget(client);
    }
    this.load();
  }

  /** Fetches what is new; a hidden page fetches nothing. */
  load() {
    if (document.hidden) return;
    for (const client of this.wanted.keys()) this.load_one(client);
  }

  forget(client) {
    this.shown.delete(client);
    this.show(client, null);
  }

  async load_one(client) {
    if (this.busy.has(client)) return;
    this.busy.add(client);
    try {
      for (;;) {
        const wanted = this.wanted.get(client);
        if (!wanted || wanted.number === this.shown.get(client)) return;
        const reply = await fetch(wanted.path, { cache: "no-store" });
        // it has left: the next message says so
        if (!reply.ok) return;
        const drawing = read_drawing(await reply.arrayBuffer());
        if (!this.wanted.has(client)) return;
        this.shown.set(client, wanted.number);
        this.show(client, drawing);
      }
    } catch (error) {
      this.trouble(`A drawing cannot be shown: ${error.message}`);
    } finally {
      this.busy.delete(client);
    }
  }
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Reads an eye file: the mesh of the tool or of an object, as it is drawn.

const kMagic = "HAPTEYE1";
const kHeader = 80; // bytes
export const kTool = 0xffffffff;

/** {object, colour, name, vertices, normals, triangles, points}; throws an Error with the reason. */
export function read_eye(buffer) {
  if (buffer.byteLength < kHeader) throw new Error("the eye file is shorter than its header");
  const text = (at, length) =>
    new TextDecoder().decode(new Uint8Array(buffer, at, length)).replace(/\0.*$/s, "");
  if (text(0, 8) !== kMagic) throw new Error("the file does not begin with HAPTEYE1");
  const view = new DataView(buffer);
  const [n_vertices, n_triangles, n_points, object] = [8, 12, 16, 20].map((at) =>
    view.getUint32(at, true),
  );
  const colour = [24, 28, 32, 36].map((at) => view.getFloat32(at, true));
  const wanted = kHeader + 4 * 3 * (2 * n_vertices + n_triangles + n_points);
  if (wanted !== buffer.byteLength) {
    throw new Error(`the eye file has ${buffer.byteLength} bytes, its header asks for ${wanted}`);
  }
  let at = kHeader;
  const take = (Kind, count) => {
    const part = new Kind(buffer, at, count); // every machine a browser runs on is little endian
    at += 4 * count;
    return part;
  };
  const vertices = take(Float32Array, 3 * n_vertices);
  const normals = take(Float32Array, 3 * n_vertices);
  const triangles = take(Uint32Array, 3 * n_triangles);
  const points = take(Float32Array, 3 * n_points);
  if (triangles.some((index) => index >= n_vertices)) {
    throw new Error("a triangle of the eye file names a vertex that is not there");
  }
  return { object, colour, name: text(40, 40), vertices, normals, triangles, points };
}

/** Of an eye file of convex pieces the number of its piece for each vertex, from 0 on in the order of
 *  the vertices. No two pieces share a vertex, so a piece is what its triangles connect. */
export function pieces_of({ vertices, triangles }) {
  const parent = Uint32Array.from({ length: vertices.length / 3 }, (_, i) => i);
  const root = (vertex) => {
    let at = vertex;
    while (parent[at] !== at) {
      parent[at] = parent[parent[at]]; // halves the way of the next search
      at = parent[at];
    }
    return at;
  };
  for (let i = 0; i < triangles.length; i += 3) {
    const lowest = Math.min(...triangles.subarray(i, i + 3).map(root));
    for (let k = i; k < i + 3; k += 1) parent[root(triangles[k])] = lowest;
  }
  const numbers = new Map();
  return Uint32Array.from(parent, (_, vertex) => {
    const of = root(vertex);
    if (!numbers.has(of)) numbers.set(of, numbers.size);
    return numbers.get(of);
  });
}

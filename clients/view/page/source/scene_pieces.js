// SPDX-License-Identifier: GPL-3.0-or-later
// The colours of convex pieces.

import { Color } from "three";
import { pieces_of } from "./eye.js";

const kGolden = 0.6180339887498949; // hues that follow one another by the golden section differ much

/** Red, green and blue of each vertex, one colour a piece. */
export function piece_colours(eye) {
  const pieces = pieces_of(eye);
  const colours = new Float32Array(eye.vertices.length);
  const colour = new Color();
  pieces.forEach((piece, vertex) => {
    colour.setHSL((kGolden * piece) % 1, 0.55, 0.6);
    colour.toArray(colours, 3 * vertex);
  });
  return colours;
}

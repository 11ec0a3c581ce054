// SPDX-License-Identifier: GPL-3.0-or-later
// The camera by keyboard, while the picture has the focus and the hand is not being led.

const kTurn = 0.12; // [rad] a key press
const kShift = 0.05; // of the picture's height
const kNearer = 1.12;

const kMoves = {
  ArrowLeft: { turn: [-kTurn, 0] },
  ArrowRight: { turn: [kTurn, 0] },
  ArrowUp: { turn: [0, kTurn] },
  ArrowDown: { turn: [0, -kTurn] },
  "+": { nearer: kNearer },
  "=": { nearer: kNearer },
  "-": { nearer: 1 / kNearer },
};
const kShiftMoves = {
  ArrowLeft: { shift: [-kShift, 0] },
  ArrowRight: { shift: [kShift, 0] },
  ArrowUp: { shift: [0, kShift] },
  ArrowDown: { shift: [0, -kShift] },
};
const kViewKeys = { 0: "start", Home: "start", 1: "front", 2: "side", 3: "top" };

export function listen_to_camera_keys(canvas, stage, is_leading) {
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || is_leading()) return;
    const move = (event.shiftKey && kShiftMoves[event.key]) || kMoves[event.key];
    const view = kViewKeys[event.key];
    if (!move && !view) return;
    event.preventDefault();
    if (move) stage.move(move);
    else stage.view(view);
  });
}

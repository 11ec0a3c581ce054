// SPDX-License-Identifier: GPL-3.0-or-later
// Buttons, labels and legend around the picture, the help, and the shortcuts of the whole page.

import { by_id, make, write } from "./dom.js";
import { round_down } from "./format.js";
import { listen_to_camera_keys } from "./stage_keys.js";

/** Shortcuts that hold wherever no text is being typed: key, the button that it presses. */
const kShortcuts = {
  "?": "help",
  t: "touch",
  f: "plot-pause",
  g: "shell",
  c: "pieces",
  k: "play",
  ",": "step-back",
  ".": "step-on",
  "[": "from-here",
  "]": "to-here",
  n: "next",
  p: "previous",
};

const kChecks = new Set(["shell", "pieces"]); // by their label: the box itself has no place

const is_typing = ({ target }) =>
  target instanceof Element && target.closest("input:not([type=checkbox], [type=range]), select");

export function set_up_stage_tools({ stage, plots, player, touch, state, show_pieces }) {
  const on = (id, event, action) => by_id(id).addEventListener(event, action);
  for (const name of ["start", "front", "side", "top"])
    on(`view-${name}`, "click", () => stage.view(name));
  on("shell", "change", () => stage.show_shell(by_id("shell").checked));
  on("pieces", "change", show_pieces);
  on("touch", "click", () => {
    touch.set_on(!touch.on);
    if (touch.on) by_id("stage").focus({ preventScroll: true });
  });
  on("hold", "click", () => touch.set_hold(!touch.hold));
  on("plot-pause", "click", () => plots.set_paused(!plots.paused));
  on("plot-reset", "click", () => plots.reset());
  on("help", "click", toggle_help);
  listen_to_camera_keys(by_id("stage"), stage, () => touch.on);
  document.addEventListener("keydown", (event) => shortcut(event, touch));
  stage.on_resize = () => show_labels(stage, state.columns);
  by_id("stage").addEventListener("webglcontextlost", (event) => event.preventDefault());
}

function toggle_help() {
  const help = by_id("help-panel");
  if (help.open) help.close();
  else help.showModal();
}

function shortcut(event, touch) {
  if (event.ctrlKey || event.metaKey || event.altKey || is_typing(event)) return;
  if (by_id("help-panel").open && event.key !== "?") return;
  // while the hand is led, letters on the picture move it
  if (touch.on && event.target === by_id("stage") && event.key !== "t" && event.key !== "?") return;
  const button = by_id(kShortcuts[event.key] ?? "");
  if (!button || button.disabled || button.closest("[hidden]")) return;
  if (button.offsetParent === null && !kChecks.has(button.id)) return;
  event.preventDefault();
  button.click();
}

/** Names of the columns over their pictures. */
export function show_labels(stage, columns) {
  const several = columns.length > 1;
  by_id("column-labels").replaceChildren(
    ...(several ? columns : []).map((name, index) => {
      const { x, y, width } = stage.cell(index);
      const label = make(
        "span",
        { className: `column-label key-column-${index % 8}` },
        make("span", { className: "swatch" }),
        name,
      );
      label.style.left = `${x + 8}px`;
      label.style.top = `${y + 8}px`;
      label.style.maxWidth = `${width - 16}px`;
      return label;
    }),
  );
}

const kLongestBar = 72; // [px]

/** What the arrows and the grid measure: bars as long as in the picture at its centre. */
export function show_legend(stage) {
  const pixels = 1 / stage.metres_per_pixel(stage.orbit.target.toArray()); // per metre
  const bar = (name, metres) => {
    by_id(`bar-${name}`).style.width =
      `${Math.min(Math.max(metres * pixels, 2), 2 * kLongestBar).toFixed(0)}px`;
  };
  const round = (scale) => round_down(kLongestBar / pixels / scale);
  const force = round(stage.scales.force);
  const torque = round(stage.scales.torque);
  bar("force", force * stage.scales.force);
  bar("torque", torque * stage.scales.torque);
  bar("grid", stage.rules[0].cell);
  write(by_id("legend-grid"), stage.rules[0].text);
  write(by_id("legend-force"), `${Number(force.toPrecision(3))} N`);
  write(
    by_id("legend-torque"),
    torque < 1 ? `${Number((torque * 1e3).toPrecision(3))} mN·m` : `${torque} N·m`,
  );
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The joints of a scene: where each stands between its end stops.

import { by_id, make, write } from "./dom.js";
import { fixed } from "./format.js";

const kDegree = 180 / Math.PI;

/** A coordinate for people: degrees for one that turns, millimetres for one that slides. */
export function coordinate(joint, value) {
  return joint.turns ? `${fixed(value * kDegree, 1)}°` : `${fixed(value * 1e3, 1)} mm`;
}

/** Its share of the way from one end stop to the other, 0 to 1; null where it has not both. */
export function travel(joint, value) {
  const { lower, upper } = joint;
  if (lower === null || upper === null || !(upper > lower)) return null;
  return Math.min(1, Math.max(0, (value - lower) / (upper - lower)));
}

/** One row for each joint: name, kind, coordinate and, with both end stops, a bar of its travel. */
export class Joints {
  set_scene(scene) {
    this.joints = scene.joints ?? [];
    by_id("joints-section").hidden = this.joints.length === 0;
    this.rows = this.joints.map((joint) => {
      const value = make("td", {}, "–");
      const bar = make("meter", { min: 0, max: 1, value: 0, "aria-label": `travel of ${joint.name}` });
      const ends = [joint.lower, joint.upper].map((end) =>
        end === null ? "" : coordinate(joint, end),
      );
      const way = make("td", {});
      if (travel(joint, 0) !== null) way.append(`${ends[0]} `, bar, ` ${ends[1]}`);
      const row = make(
        "tr",
        { "data-joint": joint.name },
        make("th", { scope: "row" }, joint.name),
        make("td", {}, joint.kind),
        value,
        way,
      );
      return { row, value, bar };
    });
    by_id("joints").replaceChildren(...this.rows.map(({ row }) => row));
  }

  show(frame) {
    this.rows?.forEach(({ value, bar }, i) => {
      const position = frame.joints[i]?.position ?? NaN;
      write(value, coordinate(this.joints[i], position));
      const share = travel(this.joints[i], position);
      if (share !== null) bar.value = share;
    });
  }
}

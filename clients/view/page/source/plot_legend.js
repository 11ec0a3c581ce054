// SPDX-License-Identifier: GPL-3.0-or-later
// The words and numbers of a plot: its legend, and a reading at the cursor.

import { make, write } from "./dom.js";
import { clock, fixed } from "./format.js";

const text_of = (definition, value) =>
  typeof value === "number" ? fixed(value, definition.digits) : "–";

/** A line of text for a plot's reading: "12.345 s: x 0.10, y 0.20 N". */
export function reading(definition, lines, time, values) {
  const parts = lines.map(({ name }, i) => `${name} ${text_of(definition, values[i])}`);
  return `${definition.title} at ${clock(time)}: ${parts.join(", ")} ${definition.unit}`;
}

/** The legend of a plot: a coloured name and a number for each line. */
export class Legend {
  constructor(definition, lines) {
    this.definition = definition;
    this.values = lines.map(() => make("span", { className: "value" }, "–"));
    this.element = make(
      "div",
      { className: "legend" },
      ...lines.map(({ name, colour }, i) =>
        make(
          "span",
          { className: `key key-${colour}`, title: name },
          make("span", { className: "swatch" }),
          make("span", { className: "name" }, name),
          this.values[i],
        ),
      ),
    );
  }

  show(values) {
    this.values.forEach((element, i) => write(element, text_of(this.definition, values[i])));
  }
}

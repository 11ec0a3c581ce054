// SPDX-License-Identifier: GPL-3.0-or-later
// The five plots: one axis of time for all, live or of a recording, several columns laid over.

import { throttled } from "./dom.js";
import { join } from "./history.js";
import { Plot } from "./plot.js";

/** title, unit, least height in it, factor from SI, digits of a reading, and which
 * quantities (indices of kQuantities). */
export const kPlots = [
  {
    title: "Force",
    unit: "N",
    least: 0.5,
    factor: 1,
    digits: 2,
    lines: [
      [0, "x", "x"],
      [1, "y", "y"],
      [2, "z", "z"],
      [3, "|F|", "ink"],
    ],
    whole: 3,
  },
  {
    title: "Torque",
    unit: "mN·m",
    least: 10,
    factor: 1e3,
    digits: 1,
    lines: [
      [4, "x", "x"],
      [5, "y", "y"],
      [6, "z", "z"],
      [7, "|τ|", "ink"],
    ],
    whole: 7,
  },
  {
    title: "Depth",
    unit: "mm",
    least: 0.5,
    factor: 1e3,
    digits: 3,
    lines: [[8, "depth", "accent"]],
    whole: 8,
  },
  {
    title: "Wake lateness",
    unit: "µs",
    least: 100,
    factor: 1e6,
    digits: 0,
    lines: [[9, "late", "accent"]],
    whole: 9,
  },
  {
    title: "Contact rate",
    unit: "Hz",
    least: 100,
    factor: 1,
    digits: 0,
    lines: [[10, "rate", "accent"]],
    whole: 10,
  },
];
export const kWindow = 10; // [s] of a session
const kShortest = 0.004; // [s] that can be zoomed to: four ticks
const kColumnColours = 8; // --column-0 …

/** Lines of a plot: of one column its components, of several the whole of each. */
export function lines_of(plot, columns) {
  if (columns.length <= 1) {
    return plot.lines.map(([quantity, name, colour]) => ({ column: 0, quantity, name, colour }));
  }
  return columns.map((name, column) => ({
    column,
    quantity: plot.whole,
    name,
    colour: `column-${column % kColumnColours}`,
  }));
}

export class Plots {
  /** on_zoom(from, to) or on_zoom(null) is told of a new range; on_pick(time) of a click in a log. */
  constructor(container, { on_zoom, on_pick, on_pause, say }) {
    Object.assign(this, { container, on_zoom, on_pick, on_pause });
    this.say = (text) => {
      this.reading = text;
      this.read_out();
    };
    this.read_out = throttled(() => say(this.reading), 700);
    this.columns = [];
    this.range = null; // zoomed to
    this.frozen = null; // the tables of the moment of a pause
    this.plots = [];
    this.live = true;
    this.origin = 0; // [s] of the session's clock, where its labels begin
  }

  set_origin(origin) {
    if (origin === this.origin) return;
    this.origin = origin;
    this.redraw();
  }

  set_columns(columns, live) {
    if (live === this.live && columns.join("\n") === this.columns.join("\n")) return;
    this.columns = columns;
    this.live = live;
    for (const plot of this.plots) plot.destroy();
    this.plots = kPlots.map(
      (definition) => new Plot(definition, lines_of(definition, columns), this),
    );
    this.container.replaceChildren(...this.plots.map(({ element }) => element));
    this.tables = columns.map(() => [[]]);
    this.range = null;
    this.frozen = null;
  }

  get paused() {
    return this.frozen !== null;
  }

  set_paused(paused) {
    this.frozen = paused ? this.tables : null;
    if (!paused) this.range = null;
    this.on_pause(paused);
    this.draw();
  }

  /** Live: the samples of each column. A pause keeps what it showed. */
  take(histories) {
    this.tables = histories.map((history) => history.view([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]));
    if (!this.paused) this.draw();
  }

  /** Of a log: tables as `take` makes them, over [from, to]. */
  show_overview(tables, from, to) {
    this.tables = tables;
    this.whole = [from, to];
    this.draw();
  }

  get shown_range() {
    if (this.range) return this.range;
    if (!this.live && this.whole) return this.whole;
    const tables = this.frozen ?? this.tables;
    const newest = Math.max(...tables.map(([times]) => times.at(-1) ?? -Infinity));
    return Number.isFinite(newest) ? [newest - kWindow, newest] : [0, kWindow];
  }

  draw() {
    const tables = this.frozen ?? this.tables ?? [];
    const range = this.shown_range;
    for (const plot of this.plots) plot.show(this.data_of(plot, tables), range);
  }

  data_of({ definition, lines }, tables) {
    const scaled = (table, quantity) =>
      (table[quantity + 1] ?? []).map((value) =>
        typeof value === "number" ? value * definition.factor : value,
      );
    if (tables.length <= 1) {
      const table = tables[0] ?? [[]];
      return [table[0], ...lines.map(({ quantity }) => scaled(table, quantity))];
    }
    return join(
      lines.map(({ column, quantity }) => [tables[column][0], scaled(tables[column], quantity)]),
    );
  }

  zoom(from, to) {
    if (!(to - from >= kShortest)) return;
    if (this.live && !this.paused) this.set_paused(true);
    this.range = [from, to];
    this.on_zoom(from, to);
    this.draw();
  }

  zoom_about(centre, factor) {
    const [from, to] = this.shown_range;
    const middle = centre ?? (from + to) / 2;
    this.zoom(middle - (middle - from) * factor, middle + (to - middle) * factor);
  }

  reset() {
    this.range = null;
    if (this.live) this.set_paused(false);
    this.on_zoom(null);
    this.draw();
  }

  /** Time of the picture above, of a log: a line in each plot. */
  set_now(time) {
    if (this.now === time) return;
    this.now = time;
    for (const plot of this.plots) {
      plot.redraw();
      plot.read();
    }
  }

  redraw() {
    for (const plot of this.plots) plot.redraw();
  }
}

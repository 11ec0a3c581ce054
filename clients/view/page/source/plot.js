// SPDX-License-Identifier: GPL-3.0-or-later
// One plot: uPlot in a frame with title and legend, by mouse and by keyboard.

import uPlot from "uplot";
import { css, make } from "./dom.js";
import { clock, fixed, value_range } from "./format.js";
import { Legend, reading } from "./plot_legend.js";

const kSync = uPlot.sync("hapticd");
const kStep = 8; // [px] a key press moves the cursor
const kLabelGap = 4; // [px] on either side of a label of the upright axis

/** Digits so that each label is its value: steps are 1, 2, 2.5 or 5 times a power of ten. */
function labels(plot, splits) {
  const step = Math.abs((splits[1] ?? 1) - splits[0]) || 1;
  const whole = (digits) => Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) < 1e-6;
  const digits = [0, 1, 2, 3, 4, 5].find(whole) ?? 6;
  return splits.map((value) => fixed(value, digits));
}

/** As wide as the widest of these labels, and never narrower than `least` [px]. */
function width_of(plot, texts, font, least) {
  plot.ctx.save();
  plot.ctx.font = font;
  const widest = Math.max(0, ...(texts ?? []).map((text) => plot.ctx.measureText(text).width));
  plot.ctx.restore();
  return Math.max(least, Math.ceil(widest) + 2 * kLabelGap);
}

/** Labels at round times of the session, whatever the clock began with: `origin` is its zero. */
function round_times(origin, from, to, step) {
  const first = Math.ceil((from - origin) / step - 1e-9);
  const count = Math.max(Math.floor((to - origin) / step + 1e-9) - first + 1, 0);
  return Array.from({ length: count }, (_, i) => origin + (first + i) * step);
}

function seconds(times) {
  const step = (times[1] ?? 1) - times[0];
  return times.map((value) =>
    value < -1e-6 ? "" : step >= 0.999 ? clock(Math.round(value)).replace(/\.000$/, "") : fixed(value, step < 0.01 ? 3 : 2),
  );
}

export class Plot {
  constructor(definition, lines, owner) {
    Object.assign(this, { definition, lines, owner });
    this.legend = new Legend(definition, lines);
    this.body = make("div", {
      className: "plot-body",
      tabIndex: 0,
      role: "img",
      "aria-label": `${definition.title} in ${definition.unit} over time`,
    });
    this.element = make(
      "figure",
      { className: "plot" },
      make(
        "figcaption",
        {},
        make("span", { className: "plot-title" }, definition.title),
        make("span", { className: "unit" }, definition.unit),
        this.legend.element,
      ),
      this.body,
    );
    this.uplot = new uPlot(this.options(), [[], ...lines.map(() => [])], this.body);
    this.body.addEventListener("keydown", (event) => this.key(event));
    this.watch = new ResizeObserver(() => this.resize());
    this.watch.observe(this.body);
  }

  options() {
    const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
    const font = `${Math.round(0.77 * rem)}px system-ui, sans-serif`;
    const axis = {
      stroke: () => css("quiet"),
      font,
      ticks: { show: false },
      grid: { stroke: () => css("grid-line"), width: 1 },
    };
    return {
      width: 200,
      height: 100,
      legend: { show: false },
      padding: [6, 1.2 * rem, 0, 0], // half of the last label of time
      pxAlign: 1,
      scales: {
        x: { time: false, auto: false },
        y: { range: (_, low, high) => value_range(low, high, this.definition.least) },
      },
      axes: [
        {
          ...axis,
          size: 1.4 * rem,
          gap: 2,
          space: 4 * rem,
          splits: (_, axis_index, from, to, step) =>
            round_times(this.owner.origin, from, to, step),
          values: (_, splits) => seconds(splits.map((time) => time - this.owner.origin)),
        },
        {
          ...axis,
          size: (plot, texts) => width_of(plot, texts, font, 3.2 * rem),
          gap: kLabelGap,
          space: 1.4 * rem,
          values: labels,
        },
      ],
      series: [
        {},
        ...this.lines.map(({ colour }) => ({
          stroke: () => css(colour),
          width: colour === "ink" ? 1.5 : 1.1,
          points: { show: false },
        })),
      ],
      cursor: {
        sync: { key: kSync.key },
        y: false,
        points: { size: 5 },
        drag: { x: true, y: false, setScale: false },
        bind: {
          dblclick: () => () => {
            this.owner.reset();
            return null;
          },
          click: () => (event) => {
            this.clicked(event);
            return null;
          },
        },
      },
      hooks: {
        setSelect: [(plot) => this.selected(plot)],
        setCursor: [() => this.read()],
        draw: [(plot) => this.draw_now(plot)],
      },
    };
  }

  show(data, [from, to]) {
    this.uplot.batch(() => {
      this.uplot.setData(data, false);
      this.uplot.setScale("x", { min: from, max: to });
    });
    this.read();
  }

  redraw() {
    this.uplot.redraw(false, true);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.body;
    if (width > 0 && height > 0) this.uplot.setSize({ width, height });
  }

  /** The legend has the values at the cursor, without one the newest. */
  read() {
    if (!this.uplot) return;
    const { data, cursor } = this.uplot;
    const at = cursor.idx ?? this.newest(data[0]);
    this.legend.show(data.slice(1).map((column) => column[at]));
  }

  newest(times) {
    const now = this.owner.now;
    if (this.owner.live || now === undefined) return times.length - 1;
    return times.length > 0 ? this.uplot.valToIdx(now) : -1;
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 3) return;
    this.owner.zoom(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  clicked() {
    const { left } = this.uplot.cursor;
    if (!this.owner.live && left >= 0 && !this.uplot.select.width) {
      this.owner.on_pick(this.uplot.posToVal(left, "x"));
    }
  }

  draw_now(plot) {
    const time = this.owner.now;
    if (this.owner.live || time === undefined) return;
    const [from, to] = [plot.scales.x.min, plot.scales.x.max];
    if (!(time >= from && time <= to)) return;
    const x = Math.round(plot.valToPos(time, "x", true));
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = css("now");
    ctx.lineWidth = Math.max(1, devicePixelRatio);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { key } = event;
    if (key === "ArrowLeft" || key === "ArrowRight")
      this.move_cursor(key === "ArrowLeft" ? -kStep : kStep);
    else if (key === "+" || key === "=") this.owner.zoom_about(this.cursor_time(), 0.5);
    else if (key === "-") this.owner.zoom_about(this.cursor_time(), 2);
    else if (key === "Home" || key === "0" || key === "Escape") this.owner.reset();
    else if (key === "Enter" && !this.owner.live) this.clicked();
    else return;
    event.preventDefault();
  }

  cursor_time() {
    const { left } = this.uplot.cursor;
    return left >= 0 ? this.uplot.posToVal(left, "x") : null;
  }

  move_cursor(pixels) {
    const { cursor, over, data } = this.uplot;
    const width = over.clientWidth;
    const from = cursor.left >= 0 ? cursor.left : width;
    this.uplot.setCursor({ left: Math.min(Math.max(from + pixels, 0), width), top: 1 });
    const index = this.uplot.cursor.idx;
    if (index === null || index === undefined) return;
    this.owner.say(
      reading(
        this.definition,
        this.lines,
        data[0][index] - this.owner.origin,
        data.slice(1).map((c) => c[index]),
      ),
    );
  }

  destroy() {
    this.watch.disconnect();
    this.uplot.destroy();
  }
}

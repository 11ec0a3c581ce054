// SPDX-License-Identifier: GPL-3.0-or-later
// A recording: where in it the picture is, playing, stepping, loops, marks, and its overview.

import { by_id, css, throttled, write } from "./dom.js";
import { clock, count, some } from "./format.js";
import { tables_of } from "./overview.js";

const kOverviewSteps = 900; // of one request: about a pixel each
const kGrowthPeriod = 2000; // [ms] between two overviews of a recording that grows
const kKinds = { contact: "contact", fault: "fault", late: "late tick" };

export class Player {
  /** send(message) sends; plots shows the overview; say(text) speaks. */
  constructor({ send, plots, say }) {
    Object.assign(this, { send, plots, say });
    this.scene = null;
    this.tick = 0;
    this.playing = false;
    this.selection = [null, null]; // ticks
    this.slider = by_id("slider");
    this.fetch_later = throttled(() => this.fetch_overview(), 150);
    this.fetch_growth = throttled(() => this.fetch_overview(), kGrowthPeriod);
    this.seek_later = throttled(() => this.seek(Number(this.slider.value)), 30);
    this.listen();
  }

  listen() {
    this.slider.addEventListener("input", () => {
      this.held = true;
      this.seek_later();
      this.tell(Number(this.slider.value));
    });
    this.slider.addEventListener("change", () => {
      this.held = false;
    });
    by_id("play").addEventListener("click", () => this.toggle());
    by_id("speed").addEventListener("change", () => {
      if (this.playing) this.play();
    });
    const on = (id, action) => by_id(id).addEventListener("click", action);
    on("step-back", () => this.step(-1));
    on("step-on", () => this.step(1));
    on("previous", () => this.next(-1));
    on("next", () => this.next(1));
    on("from-here", () => this.select(0));
    on("to-here", () => this.select(1));
    on("select-view", () => this.select_view());
    on("select-none", () => this.set_selection([null, null]));
    by_id("loop").addEventListener("change", () => this.send_loop());
    new ResizeObserver(() => this.draw_marks()).observe(by_id("marks"));
  }

  /** Takes the scene of a log; the same one again where the recording has grown. */
  set_scene(scene) {
    const grown =
      this.scene?.session === scene.session && this.scene.first_tick === scene.first_tick;
    this.scene = scene;
    this.slider.min = scene.first_tick;
    this.slider.max = scene.last_tick;
    if (!grown) this.set_selection([null, null]);
    const marks = scene.marks ?? [];
    const told = Object.entries(kKinds).map(([kind, word]) =>
      some(marks.filter((mark) => mark.kind === kind).length, word),
    );
    write(by_id("mark-counts"), `${told.join(", ")}${scene.growing ? "; still recording" : ""}`);
    write(by_id("log-length"), clock(scene.last_time - scene.first_time));
    this.draw_marks();
    if (grown) this.fetch_growth();
    else this.fetch_later();
  }

  show(frame) {
    this.tick = frame.tick;
    if (!this.scene) return;
    if (!this.held) this.slider.value = frame.tick;
    this.tell(frame.tick);
    this.plots.set_now(frame.time);
    const at_end = frame.tick >= this.scene.last_tick && !this.scene.growing;
    if (this.playing && at_end && !by_id("loop").checked) this.set_playing(false);
  }

  tell(tick) {
    const time = this.time_of(tick);
    write(by_id("log-time"), clock(time - this.scene.first_time));
    write(by_id("log-tick"), `tick ${count(tick)}`);
    this.slider.setAttribute(
      "aria-valuetext",
      `${clock(time - this.scene.first_time)} of ${clock(this.scene.last_time - this.scene.first_time)}`,
    );
  }

  // ticks lie on a grid of time, so a straight line between first and last is exact
  time_of(tick) {
    const { first_tick, last_tick, first_time, last_time } = this.scene;
    const share = (tick - first_tick) / Math.max(last_tick - first_tick, 1);
    return first_time + share * (last_time - first_time);
  }

  tick_of(time) {
    const { first_tick, last_tick, first_time, last_time } = this.scene;
    const share = (time - first_time) / Math.max(last_time - first_time, 1e-9);
    const tick = Math.round(first_tick + share * (last_tick - first_tick));
    return Math.min(Math.max(tick, first_tick), last_tick);
  }

  seek(tick) {
    this.send({ type: "seek", tick });
  }

  toggle() {
    if (this.playing) this.stop();
    else this.play();
  }

  play() {
    if (this.tick >= this.scene.last_tick && !this.scene.growing) this.seek(this.scene.first_tick);
    this.send({ type: "play", speed: Number(by_id("speed").value) });
    this.set_playing(true);
  }

  stop() {
    this.send({ type: "stop" });
    this.set_playing(false);
  }

  set_playing(playing) {
    this.playing = playing;
    write(by_id("play"), playing ? "Stop" : "Play");
    by_id("play").setAttribute("aria-pressed", String(playing));
  }

  step(ticks) {
    if (this.playing) this.stop();
    this.send({ type: "step", ticks });
  }

  next(direction) {
    const kind = by_id("kind").value;
    const beyond = (this.scene.marks ?? []).some(
      (mark) => mark.kind === kind && (mark.tick - this.tick) * direction > 0,
    );
    if (!beyond) {
      this.say(`No ${kKinds[kind]} ${direction > 0 ? "after" : "before"} this tick.`);
      return;
    }
    this.send({ type: "next", kind, direction });
  }

  select(end) {
    const selection = [...this.selection];
    selection[end] = this.tick;
    if (selection[0] !== null && selection[1] !== null && selection[0] > selection[1]) {
      selection[1 - end] = null;
    }
    this.set_selection(selection);
  }

  select_view() {
    const [from, to] = this.plots.shown_range;
    this.set_selection([this.tick_of(from), this.tick_of(to)]);
  }

  set_selection(selection) {
    this.selection = selection;
    const [from, to] = this.bounds();
    const some_selected = selection.some((tick) => tick !== null);
    write(
      by_id("selection"),
      some_selected ? `ticks ${count(from)} to ${count(to)}` : "whole recording",
    );
    by_id("export").href = `/export.csv?from=${from}&to=${to}`;
    this.send_loop();
    this.draw_marks();
  }

  bounds() {
    const { first_tick = 0, last_tick = 0 } = this.scene ?? {};
    return [this.selection[0] ?? first_tick, this.selection[1] ?? last_tick];
  }

  send_loop() {
    const wanted = by_id("loop").checked;
    if (!wanted && !this.looping) return;
    this.looping = wanted;
    const [from, to] = wanted ? this.bounds() : [null, null];
    this.send({ type: "loop", from, to });
  }

  async fetch_overview() {
    if (!this.scene) return;
    const [from, to] = this.plots.range ?? [this.scene.first_time, this.scene.last_time];
    const query = `from=${from}&to=${to}&columns=${kOverviewSteps}`;
    try {
      const reply = await fetch(`/overview.json?${query}`, { cache: "no-store" });
      if (!reply.ok) throw new Error(`the bridge says ${reply.status}`);
      this.plots.show_overview(
        tables_of(await reply.json()),
        this.scene.first_time,
        this.scene.last_time,
      );
    } catch (error) {
      this.say(`The overview could not be read: ${error.message}`);
    }
  }

  draw_marks() {
    const canvas = by_id("marks");
    const [width, height] = [
      canvas.clientWidth * devicePixelRatio,
      canvas.clientHeight * devicePixelRatio,
    ];
    if (!this.scene || width === 0) return;
    canvas.width = width;
    canvas.height = height;
    const pen = canvas.getContext("2d");
    const { first_tick, last_tick, marks = [] } = this.scene;
    const x = (tick) => ((tick - first_tick) / Math.max(last_tick - first_tick, 1)) * width;
    if (this.selection.some((tick) => tick !== null)) {
      const [from, to] = this.bounds().map(x);
      pen.fillStyle = css("selection");
      pen.fillRect(from, 0, Math.max(to - from, 2), height);
    }
    for (const [row, kind] of Object.keys(kKinds).entries()) {
      pen.fillStyle = css(`mark-${kind}`);
      for (const mark of marks) {
        if (mark.kind === kind)
          pen.fillRect(x(mark.tick) - 1, (row * height) / 3 + 1, 2, height / 3 - 2);
      }
    }
  }
}

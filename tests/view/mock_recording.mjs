// SPDX-License-Identifier: GPL-3.0-or-later
// The mock's recording: half a minute of the synthetic session, and a player in it.

import { is_faulted, is_late, kPeriod, tick_at } from "./mock_session.mjs";

const kFirstTick = 1000;
const kTicks = 30000;
// as `hapt view --clearance` gives it; no tick of the synthetic session is meant
export const kTightest = {
  object: 0,
  distance: 0.0012,
  tick: 1500,
  tool: [0.01, 0.02, 0.03, 0, 1, 0, 0],
  tool_point: [0.01, 0.02, 0.03],
  object_point: [0.01, 0.0212, 0.03],
  text: "The tool is nearest to 'block' at 0.500 s: 1.2 mm",
};
const kVectors = { force: "force", torque: "torque" };

export class Recording {
  constructor(columns, growing) {
    this.columns = columns;
    this.growing = growing;
    this.first_tick = kFirstTick;
    this.last_tick = kFirstTick + kTicks;
  }

  marks() {
    if (this.marks_until === this.last_tick) return this.kept_marks;
    this.marks_until = this.last_tick;
    this.kept_marks = [];
    const add = (tick, kind) => this.kept_marks.push({ tick, time: tick * kPeriod, kind });
    let touched = false;
    for (let tick = this.first_tick; tick <= this.last_tick; tick += 1) {
      const touches = tick_at(tick, 0).depth > 0;
      if (touches && !touched) add(tick, "contact");
      if (is_faulted(tick) && !is_faulted(tick - 1)) add(tick, "fault");
      if (is_late(tick)) add(tick, "late");
      touched = touches;
    }
    return this.kept_marks;
  }

  scene() {
    return {
      first_tick: this.first_tick,
      last_tick: this.last_tick,
      first_time: this.first_tick * kPeriod,
      last_time: this.last_tick * kPeriod,
      growing: this.growing,
      marks: this.marks(),
      clearance: kTightest,
    };
  }

  overview(query) {
    const [from, to, steps] = ["from", "to", "columns"].map((key) => Number(query.get(key)));
    const time = Array.from({ length: steps }, (_, i) => from + ((to - from) * i) / steps);
    const columns = Array.from({ length: this.columns }, (_, c) =>
      this.overview_of(c, time, (to - from) / steps),
    );
    return { from, to, time, columns };
  }

  overview_of(column, times, step) {
    const table = {};
    const put = (name, value, i) => {
      const row = (table[name] ??= { min: times.map(() => null), max: times.map(() => null) });
      row.min[i] = Math.min(row.min[i] ?? Infinity, value);
      row.max[i] = Math.max(row.max[i] ?? -Infinity, value);
    };
    times.forEach((time, i) => {
      for (const share of [0, 0.25, 0.5, 0.75]) {
        const sample = tick_at(Math.round((time + share * step) / kPeriod), column, {
          faults: true,
        });
        for (const name of Object.keys(kVectors)) {
          sample[name].forEach((value, axis) => put(`${name}_${"xyz"[axis]}`, value, i));
          put(name, Math.hypot(...sample[name]), i);
        }
        for (const name of ["depth", "wake_late", "contact_rate"]) put(name, sample[name], i);
      }
    });
    return { name: `column ${column}`, ...table };
  }

  player() {
    return new Player(this);
  }
}

class Player {
  constructor(recording) {
    Object.assign(this, { recording, tick: recording.first_tick, speed: 0, loop: null });
  }

  advance() {
    const now = performance.now();
    if (this.speed > 0) this.tick += ((now - this.then) / 1000 / kPeriod) * this.speed;
    this.then = now;
    if (this.loop && this.tick > this.loop[1]) this.tick = this.loop[0];
    this.tick = Math.min(Math.max(this.tick, this.recording.first_tick), this.recording.last_tick);
    return Math.floor(this.tick);
  }

  take(message) {
    this.then = performance.now();
    if (message.type === "seek") this.tick = message.tick;
    if (message.type === "play") this.speed = message.speed;
    if (message.type === "stop") this.speed = 0;
    if (message.type === "step") this.tick = Math.floor(this.tick) + message.ticks;
    if (message.type === "loop")
      this.loop = message.from === null ? null : [message.from, message.to];
    if (message.type !== "next") return;
    const ticks = this.recording
      .marks()
      .filter(({ kind }) => kind === message.kind)
      .map(({ tick }) => tick);
    const there =
      message.direction > 0
        ? ticks.find((tick) => tick > Math.floor(this.tick))
        : ticks.findLast((tick) => tick < Math.floor(this.tick));
    this.tick = there ?? this.tick;
  }
}

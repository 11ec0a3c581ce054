// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of now, the table of processes, and what has happened.

import { by_id, make, write } from "./dom.js";
import { kSilence } from "./health.js";
import {
  clock,
  count,
  duration,
  fixed,
  hertz,
  millimetre,
  newton,
  newton_metre,
  norm,
  some,
} from "./format.js";
import { state_words } from "./words.js";

// a number in each line where columns stand side by side: CSS keeps or folds the line ends
const vector = (v, factor, digits) =>
  Array.from(v, (value) => fixed(value * factor, digits)).join("\n");

/** Rows of the readings: [id, what it is, how a frame says it]. */
const kReadings = [
  ["force", "Force", (f) => newton(norm(f.force))],
  ["force-xyz", "x, y, z [N]", (f) => vector(f.force, 1, 2)],
  ["torque", "Torque", (f) => newton_metre(norm(f.torque))],
  ["depth", "Depth", (f) => millimetre(f.depth)],
  ["tool", "Tool x, y, z [mm]", (f) => vector(f.tool.subarray(0, 3), 1e3, 1)],
  ["speed", "Speed", (f) => `${fixed(norm(f.velocity) * 1e3, 0)} mm/s`],
  ["contacts", "Contacts that push", (f) => count(f.n_pushing)],
  ["listed", "Contacts listed", (f) => count(f.n_listed)],
  ["fade", "Weight of contacts", (f) => `${fixed(f.fade * 100, 0)} %`],
  ["late", "Woken late by", (f) => duration(f.wake_late)],
  ["busy", "Servo busy", (f) => duration(f.busy)],
  ["contact-busy", "Contact busy", (f) => duration(f.contact_busy)],
  ["skipped", "Ticks skipped", (f) => count(f.skipped)],
  ["tick", "Tick", (f) => count(f.tick)],
  ["time", "Session time", (f, origin) => clock(f.time - origin)],
];

/** The readings, one column of numbers for each column of the comparison. */
export class Readings {
  constructor() {
    this.columns = [];
    this.last = [];
  }

  set_columns(columns) {
    if (columns.join("\n") === this.columns.join("\n") && this.cells) return;
    this.columns = columns;
    this.cells = kReadings.map(() => columns.map(() => make("td", {}, "–")));
    const rows = kReadings.map(([id, name], row) =>
      make("tr", { "data-reading": id }, make("th", { scope: "row" }, name), ...this.cells[row]),
    );
    const head =
      columns.length > 1
        ? [
            make(
              "thead",
              {},
              make(
                "tr",
                {},
                make("td", {}),
                ...columns.map((name, i) =>
                  make("th", { scope: "col", className: `key-column-${i % 8}` }, name),
                ),
              ),
            ),
          ]
        : [];
    by_id("readings").replaceChildren(...head, make("tbody", {}, ...rows));
  }

  /** `origin`: where the session or log began, on its clock [s]. */
  show(frame, origin) {
    const column = Math.min(frame.column, this.columns.length - 1);
    kReadings.forEach(([, , text], row) => write(this.cells[row][column], text(frame, origin)));
    if (column === 0) this.show_state(frame.flags);
  }

  show_state(flags) {
    if (this.flags === flags) return;
    this.flags = flags;
    const words = state_words(flags);
    const shown = words.length > 0 ? words : [{ word: "free", level: "ok" }];
    by_id("state").replaceChildren(
      ...shown.map(({ word, level }) => make("li", { className: level }, word)),
    );
  }
}

const kOldAge = { servo: 0.1, contact: 0.2, sim: 0.2 }; // [s] from where a row is marked

const kind_of = (name) => name.replace(/[0-9]+$/, "");

/** The table of processes; ages of a frame are younger than those of a status. */
export class Processes {
  constructor() {
    this.status = null;
    this.received = 0;
  }

  take(status, now) {
    this.status = status;
    this.received = now;
    const { clients, viewers, missed } = status;
    write(
      by_id("watchers"),
      `${some(clients ?? 0, "client")}, ${some(viewers ?? 0, "viewer")}, ` +
        `${some(missed ?? 0, "record")} missed by the bridge`,
    );
    this.show_givers(status.giving ?? []);
  }

  /** A line for each client that the session file lets give. */
  show_givers(giving) {
    const key = JSON.stringify(giving);
    if (key === this.givers) return;
    this.givers = key;
    by_id("giving").hidden = giving.length === 0;
    by_id("giving").replaceChildren(
      ...giving.map(({ name, text, well }) =>
        make("li", { className: well ? "" : "warn" }, `${name} ${text}`),
      ),
    );
  }

  show(frame, frame_age, now) {
    if (!this.status) return;
    const rows = this.status.processes.map((process) => {
      const kind = kind_of(process.name);
      const fresh = frame?.[`age_${kind}`];
      const age = Number.isFinite(fresh)
        ? fresh + (frame_age > kSilence ? frame_age : 0)
        : process.age + (now - this.received);
      const rate = frame?.[`rate_${kind}`] ?? process.rate;
      const old = !process.runs || age > (kOldAge[kind] ?? Infinity);
      return {
        name: process.name,
        old,
        runs: process.runs,
        texts: [
          process.runs ? "runs" : "stopped",
          Number.isFinite(age) ? duration(age) : "–",
          Number.isFinite(rate) && rate > 0 ? hertz(rate) : "–",
          count(process.generation),
          String(process.pid ?? "–"),
        ],
      };
    });
    this.write_rows(rows);
  }

  write_rows(rows) {
    const body = by_id("processes");
    while (body.rows.length > rows.length) body.lastElementChild.remove();
    rows.forEach(({ name, old, texts }, index) => {
      const row =
        body.rows[index] ??
        body.appendChild(
          make("tr", {}, make("th", { scope: "row" }), ...texts.map(() => make("td"))),
        );
      row.className = old ? "bad" : "";
      write(row.cells[0], name);
      texts.forEach((text, i) => write(row.cells[i + 1], text));
    });
  }
}

const kMostEvents = 40;

/** What has happened, the newest on top. */
export function note_event(text) {
  const list = by_id("events");
  const time = new Date().toLocaleTimeString([], { hour12: false });
  list.prepend(make("li", {}, make("time", {}, time), ` ${text}`));
  while (list.children.length > kMostEvents) list.lastElementChild.remove();
  by_id("no-events").hidden = true;
}

const kRecoveredShown = 8000; // [ms]

/** The banner over everything: alerts, and for a while that all is well again. */
export class Banner {
  constructor(announce) {
    this.announce = announce;
    this.key = null;
  }

  show(alerts, recovered) {
    if (recovered) {
      this.put("good", recovered);
      this.timer = setTimeout(() => this.hide(), kRecoveredShown);
      note_event(recovered);
    } else if (alerts.length > 0) {
      const { key, text, level } = alerts[0];
      const first = this.key !== key;
      this.put(level, text, key);
      if (first && level === "bad") note_event(text);
    } else if (this.key !== null) {
      this.hide();
    }
  }

  put(level, text, key = null) {
    clearTimeout(this.timer);
    const banner = by_id("banner");
    banner.hidden = false;
    banner.className = `banner ${level}`;
    write(by_id("banner-text"), text);
    // the age in the sentence grows with each frame; it is said only when its kind changes
    if (key !== this.key || key === null) this.announce(text);
    this.key = key;
  }

  hide() {
    this.key = null;
    by_id("banner").hidden = true;
    write(by_id("banner-text"), "");
  }
}

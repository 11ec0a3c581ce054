// SPDX-License-Identifier: GPL-3.0-or-later
// The samples of the last seconds, every tick of them, as the plots want them.

/** Columns of equal length; older than `window` seconds is let go. A gap becomes a row of nulls. */
export class History {
  constructor(n_columns, window, longest_gap = 0.05) {
    this.window = window; // [s]
    this.longest_gap = longest_gap; // [s] between two samples that are still joined by a line
    this.columns = Array.from({ length: n_columns + 1 }, () => []);
    this.first = 0; // rows before it are too old; they are cut off now and then
    this.gap = false;
  }

  get length() {
    return this.columns[0].length - this.first;
  }

  get newest() {
    return this.columns[0].at(-1) ?? NaN;
  }

  clear() {
    for (const column of this.columns) column.length = 0;
    this.first = 0;
  }

  /** Samples are missing before the next one: no line is drawn to it. */
  leave_gap() {
    this.gap = this.length > 0;
  }

  /** Time goes backwards only where a session began anew: then the old samples are dropped. */
  push(time, values) {
    if (!Number.isFinite(time)) return;
    const newest = this.newest;
    if (time === newest) return;
    if (time < newest) this.clear();
    else if (this.gap || time - newest > this.longest_gap) this.append((newest + time) / 2, null);
    this.append(time, values);
    this.gap = false;
    this.trim();
  }

  append(time, values) {
    this.columns[0].push(time);
    for (let i = 1; i < this.columns.length; i += 1) {
      const value = values === null ? null : values[i - 1];
      this.columns[i].push(Number.isFinite(value) ? value : null);
    }
  }

  trim() {
    const times = this.columns[0];
    const oldest = times.at(-1) - this.window;
    while (times[this.first] < oldest) this.first += 1;
    if (this.first > 8192) {
      // rows; cutting is a copy, so it is done seldom
      for (const column of this.columns) column.splice(0, this.first);
      this.first = 0;
    }
  }

  /** Copies [times, …columns named by index]. */
  view(indices) {
    return [0, ...indices.map((i) => i + 1)].map((i) => this.columns[i].slice(this.first));
  }
}

/**
 * Several columns on one axis of time: the union of times; where a column has no sample at a time
 * it has `undefined`, over which a line is drawn on. Each of `tables` is [times, values].
 */
export function join(tables) {
  const times = [...new Set(tables.flatMap(([t]) => t))].sort((a, b) => a - b);
  const place = new Map(times.map((time, index) => [time, index]));
  return [
    times,
    ...tables.map(([t, values]) => {
      const column = new Array(times.length).fill(undefined);
      t.forEach((time, i) => {
        column[place.get(time)] = values[i];
      });
      return column;
    }),
  ];
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as people read them. A number that is not finite is a dash.

const kDash = "–";

/** Fixed digits after the point, with a true minus sign. */
export function fixed(value, digits) {
  if (!Number.isFinite(value)) return kDash;
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** Of a three-vector. */
export function norm(v) {
  return v ? Math.hypot(v[0], v[1], v[2]) : NaN;
}

export const newton = (value) => `${fixed(value, 2)} N`;
export const newton_metre = (value) => `${fixed(value * 1e3, 1)} mN·m`;
export const millimetre = (value, digits = 2) => `${fixed(value * 1e3, digits)} mm`;
export const hertz = (value) => `${fixed(value, value < 10 ? 1 : 0)} Hz`;

/** A short time, from microseconds to hours. */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return kDash;
  const size = Math.abs(seconds);
  if (size === 0) return "0 s";
  if (size < 1e-3) return `${fixed(seconds * 1e6, 0)} µs`;
  if (size < 1) return `${fixed(seconds * 1e3, size < 0.01 ? 1 : 0)} ms`;
  if (size < 60) return `${fixed(seconds, size < 10 ? 2 : 1)} s`;
  if (size < 3600) return `${Math.floor(size / 60)} min ${fixed(size % 60, 0)} s`;
  return `${Math.floor(size / 3600)} h ${Math.floor((size % 3600) / 60)} min`;
}

/** Time on a scale: m:ss.mmm, from an hour on h:mm:ss.mmm */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return kDash;
  const size = Math.round(Math.abs(seconds) * 1000) / 1000;
  const rest = (size % 60).toFixed(3).padStart(6, "0");
  const sign = seconds < 0 ? "−" : "";
  if (size < 3600) return `${sign}${Math.floor(size / 60)}:${rest}`;
  const minutes = Math.floor((size % 3600) / 60)
    .toString()
    .padStart(2, "0");
  return `${sign}${Math.floor(size / 3600)}:${minutes}:${rest}`;
}

/** An integer with thin spaces between thousands. */
export function count(value) {
  if (!Number.isFinite(value)) return kDash;
  return Math.round(value)
    .toString()
    .replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

/** "1 tick", "2 ticks". */
export function some(number, word) {
  return `${count(number)} ${word}${Math.round(number) === 1 ? "" : "s"}`;
}

/** The largest of 1, 2, 5 × 10ⁿ that is at most `value`. */
export function round_down(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  const lead = value / power;
  return power * (lead >= 5 - 1e-9 ? 5 : lead >= 2 - 1e-9 ? 2 : 1);
}

/** The range of an axis: never less than `least` high, also of a line that stays at one value, and
 *  from zero where the values are near it. */
export function value_range(low, high, least) {
  if (low === null || !Number.isFinite(low)) return [0, least];
  const span = Math.max(high - low, least);
  if (low >= 0 && low < span) return [0, Math.max(high, least) * 1.06];
  const beside = (span - (high - low)) / 2 + 0.06 * span;
  return [low - beside, high + beside];
}

/** A length on a scale, without digits that say nothing. */
export function length(metres) {
  const mm = metres * 1e3;
  if (mm >= 1000) return `${Number(metres.toPrecision(6))} m`;
  return mm >= 0.01 ? `${Number(mm.toPrecision(6))} mm` : `${Number((mm * 1e3).toPrecision(6))} µm`;
}

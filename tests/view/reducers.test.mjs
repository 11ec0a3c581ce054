// SPDX-License-Identifier: GPL-3.0-or-later
import assert from "node:assert/strict";
import { test } from "node:test";
import * as format from "../../clients/view/page/source/format.js";
import { follow, judge, kNothingYet, kWell } from "../../clients/view/page/source/health.js";
import { History, join } from "../../clients/view/page/source/history.js";

const well = {
  ...kNothingYet,
  connected: true,
  opened_once: true,
  source: "session",
  last_message: 10,
  last_frame: 10,
  age_servo: 0.001,
  age_contact: 0.002,
};
const keys = (state, now) => judge(state, now).map(({ key }) => key);

test("what is current gives no alert", () => {
  assert.deepEqual(keys(well, 10.5), []);
  assert.deepEqual(keys({ ...well, age_servo: 0.099, age_contact: 0.199 }, 10), []);
});

test("each kind of old data has its alert, the most fundamental one", () => {
  assert.deepEqual(keys({ ...well, age_servo: 0.11, age_contact: 5 }, 10), ["servo"]);
  assert.deepEqual(keys({ ...well, age_contact: 0.21 }, 10), ["contact"]);
  assert.deepEqual(keys(well, 11.1), ["silent"]);
  assert.deepEqual(keys({ ...well, last_message: 11 }, 11.1), ["frames"]);
  assert.deepEqual(keys({ ...well, gone: "hapticd has ended." }, 20), ["gone"]);
  assert.deepEqual(keys({ ...well, connected: false }, 10), ["bridge"]);
  assert.deepEqual(keys(kNothingYet, 0), ["connecting"]);
});

test("what the page itself delays is not laid to the servo, and a recording is never old", () => {
  assert.deepEqual(keys({ ...well, last_frame: 8, last_message: 8, asked: 9.5 }, 10), []);
  assert.deepEqual(keys({ ...well, source: "log" }, 100), []);
  assert.deepEqual(keys({ ...well, visible: false }, 12), []);
});

test("an alert is told after its patience, and its end says what was missed", () => {
  const bad = [{ key: "servo", text: "old", level: "bad" }];
  let step = follow(kWell, bad, 1, 100);
  assert.deepEqual(step.alerts, []);
  step = follow(step.story, bad, 1.2, 130);
  assert.equal(step.alerts.length, 1);
  step = follow(step.story, [], 4, 350);
  assert.match(step.recovered, /after 3\.00 s; 250 ticks/);
  assert.equal(follow(step.story, [], 5, 350).recovered, null);
});

test("a hiccup shorter than the patience is not told at all", () => {
  const step = follow(kWell, [{ key: "servo", text: "old", level: "bad" }], 1, 0);
  assert.equal(follow(step.story, [], 1.05, 0).recovered, null);
});

test("a history keeps its window, every sample of it", () => {
  const history = new History(1, 10);
  for (let i = 0; i < 30000; i += 1) history.push(i * 0.001, [i]);
  const [times, values] = history.view([0]);
  assert.ok(times.length >= 10000 && times.length <= 10002);
  assert.equal(values.at(-1), 29999);
  assert.ok(times.every((time, i) => i === 0 || time > times[i - 1]));
});

test("a gap is a hole in the line; time that runs backwards begins anew; the same time counts once", () => {
  const history = new History(1, 10);
  history.push(1, [1]);
  history.push(1, [1]);
  history.push(2, [2]);
  assert.deepEqual(history.view([0])[1], [1, null, 2]);
  history.push(0.5, [9]);
  assert.deepEqual(history.view([0]), [[0.5], [9]]);
  history.push(0.501, [NaN]);
  assert.deepEqual(history.view([0])[1], [9, null]);
});

test("where samples are known to be missing no line is drawn, however short the time", () => {
  const history = new History(1, 10);
  history.leave_gap();
  history.push(1, [1]);
  history.push(1.001, [2]);
  history.leave_gap();
  history.push(1.02, [3]);
  history.push(1.021, [4]);
  assert.deepEqual(history.view([0])[1], [1, 2, null, 3, 4]);
});

test("columns with different times share one axis", () => {
  const [times, a, b] = join([
    [
      [1, 3],
      [10, 30],
    ],
    [
      [2, 3],
      [200, 300],
    ],
  ]);
  assert.deepEqual(times, [1, 2, 3]);
  assert.deepEqual(a, [10, undefined, 30]);
  assert.deepEqual(b, [undefined, 200, 300]);
});

test("numbers are written as people read them", () => {
  assert.equal(format.fixed(-0.001, 2), "0.00");
  assert.equal(format.fixed(-1.5, 1), "−1.5");
  assert.equal(format.fixed(NaN, 1), "–");
  assert.equal(format.duration(0.00002), "20 µs");
  assert.equal(format.duration(0.0123), "12 ms");
  assert.equal(format.duration(75), "1 min 15 s");
  assert.equal(format.clock(61.5), "1:01.500");
  assert.equal(format.clock(59.9999), "1:00.000");
  assert.equal(format.clock(7265.25), "2:01:05.250");
  assert.equal(format.count(1234567), "1\u202f234\u202f567");
  assert.equal(format.some(1, "tick"), "1 tick");
  assert.equal(format.length(0.05), "50 mm");
  assert.deepEqual([0.7, 1, 4.9, 5, 0.002, 30].map(format.round_down), [0.5, 1, 2, 5, 0.002, 20]);
});

test("an axis never collapses, and keeps what lies on it inside", () => {
  assert.deepEqual(format.value_range(null, null, 10), [0, 10]);
  assert.deepEqual(format.value_range(0, 0, 100), [0, 106]);
  for (const [low, high] of [
    [-1, -1],
    [1000, 1000],
    [990, 1000],
    [-3, 900],
  ]) {
    const [from, to] = format.value_range(low, high, 10);
    assert.ok(from < low && to > high && to - from >= 10, `${from} ${to}`);
  }
  assert.equal(format.value_range(0.1, 30, 10)[0], 0);
});

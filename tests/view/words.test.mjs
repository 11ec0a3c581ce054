// SPDX-License-Identifier: GPL-3.0-or-later
// The page's words against the enums of the header that all processes share.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import * as words from "../../clients/view/page/source/words.js";

const header = readFileSync(new URL("../../proto/wire/wire.h", import.meta.url), "utf8");

/** Names of an enum of bits, by bit. */
function bits_of(name) {
  const body = header.match(new RegExp(`enum ${name}[^{]*{([^}]*)}`))[1];
  return [...body.matchAll(/^\s*(k\w+) = 1u << (\d+)/gm)].map(([, id, bit]) => [Number(bit), id]);
}

test("every flag of the servo and of contact has its row, at its bit", () => {
  assert.deepEqual(
    words.kServoFlags.map(([bit]) => bit),
    bits_of("ServoFlag").map(([bit]) => bit),
  );
  assert.deepEqual(
    words.kContactFlags.map(([bit]) => bit),
    bits_of("ContactFlag").map(([bit]) => bit),
  );
});

test("every fault has a sentence and a remedy", () => {
  const body = header.match(/enum class Fault[^{]*{([^}]*)}/)[1];
  const numbers = [...body.matchAll(/^\s*k\w+ = (\d+)/gm)].map(([, number]) => Number(number));
  assert.equal(words.kFaults.length, numbers.length);
  for (const number of numbers.slice(1)) {
    const [text, remedy] = words.kFaults[number];
    assert.match(text, /^[A-Z].*\.$/);
    assert.match(remedy, /\.$/);
  }
});

const bit_of = (name) => 2 ** bits_of("ServoFlag").find(([, id]) => id === name)[0];

test("a state is told in short words", () => {
  const state = words.state_words(bit_of("kServoContact") + bit_of("kServoSaturated"));
  assert.deepEqual(
    state.map(({ word }) => word),
    ["contact", "saturated"],
  );
  assert.deepEqual(words.state_words(bit_of("kServoPaused"))[0].word, "paused");
  assert.deepEqual(words.state_words(0), []);
});

test("troubles: the worst first, the fault in words, notes left out", () => {
  const flags = bit_of("kServoFault") + bit_of("kServoThermal") + bit_of("kServoSoftStart");
  const list = words.troubles({ flags, fault: 5, contact_flags: 0 });
  assert.deepEqual(
    list.map(({ level }) => level),
    ["bad", "warn"],
  );
  assert.match(list[0].text, /pose of the device jumped/);
  assert.match(words.troubles({ flags: 0, fault: 99, contact_flags: 0 })[0].text, /99/);
  assert.deepEqual(words.troubles({ flags: 1, fault: 0, contact_flags: 0 }), []);
});

test("the bridge's own texts come before the page's", () => {
  const frame = { flags: 256, fault: 5, contact_flags: 0 };
  const shown = words.shown_troubles({ faults: [{ text: "so it is", remedy: "do that" }] }, frame);
  assert.deepEqual(
    shown.map(({ text }) => text),
    ["So it is."],
  );
  assert.equal(words.shown_troubles({ faults: [] }, frame).length, 1);
  assert.deepEqual(words.shown_troubles(undefined, null), []);
});

test("what the bridge warns of comes last, and hides no fault", () => {
  const warnings = [{ text: "2 bodies out of reach (1 m)", remedy: "put a floor below" }];
  const gone = { text: "2 bodies out of reach (1 m).", remedy: "put a floor below", level: "warn" };
  assert.deepEqual(words.shown_troubles({ faults: [], warnings }, null), [gone]);
  const frame = { flags: 256, fault: 5, contact_flags: 0 };
  assert.deepEqual(words.shown_troubles({ faults: [], warnings }, frame)[1], gone);
  const paused = [{ text: "paused", remedy: "'hapt resume'" }];
  assert.deepEqual(words.shown_troubles({ faults: paused, warnings }, frame)[1], gone);
});

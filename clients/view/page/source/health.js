// SPDX-License-Identifier: GPL-3.0-or-later
// Is what the page shows true now? Pure: the present state in, alerts in words out.

import { duration, some } from "./format.js";

export const kServoAge = 0.1; // [s] a servo that is older has missed a hundred ticks
export const kContactAge = 0.2; // [s] the servo has faded its force by then
export const kSilence = 1; // [s] without any frame
export const kStatusPeriod = 2.5; // [s] two reports of status have failed

/** What was true when something last came in. Times in seconds of performance.now(). */
export const kNothingYet = {
  connected: false,
  opened_once: false,
  source: null,
  gone: null,
  visible: true,
  last_message: -Infinity,
  last_frame: -Infinity,
  asked: -Infinity,
  age_servo: NaN,
  age_contact: NaN,
};

const kConnecting = "connecting";

/** [{key, text, level}], the most fundamental first; later ones that follow from it are left out. */
export function judge(state, now) {
  if (!state.connected) {
    const text = state.opened_once
      ? "The bridge does not answer: what is shown is old. Trying again; is `hapt view` still running?"
      : "Connecting to the bridge…";
    const [key, level] = state.opened_once ? ["bridge", "bad"] : [kConnecting, "note"];
    return [{ key, text, level }];
  }
  if (state.gone !== null) return [{ key: "gone", text: state.gone, level: "bad" }];
  if (state.source !== "session" || !state.visible) return [];
  const message_age = now - state.last_message;
  const frame_age = now - Math.max(state.last_frame, state.asked);
  if (message_age > kStatusPeriod || Math.min(frame_age, message_age) > kSilence) {
    return [
      bad(
        "silent",
        `The bridge has been silent for ${duration(message_age)}: what is shown is old.`,
      ),
    ];
  }
  if (frame_age > kSilence) {
    return [bad("frames", `No new frame for ${duration(frame_age)}: what is shown is old.`)];
  }
  // as the bridge says them: how long this page takes to draw is no age of the servo
  const { age_servo: servo, age_contact: contact } = state;
  if (servo > kServoAge) {
    return [
      bad(
        "servo",
        `The servo's data are ${duration(servo)} old: pose, proxy and force are not those of now.`,
      ),
    ];
  }
  if (contact > kContactAge) {
    return [
      bad("contact", `The contacts are ${duration(contact)} old: the servo renders none of them.`),
    ];
  }
  return [];
}

const bad = (key, text) => ({ key, text, level: "bad" });

export const kWell = { since: null, unseen: 0, told: null };

/**
 * Follows the alerts. `story` is {since, unseen, told}; an alert must hold for `patience` seconds
 * before it is told, so that nothing flickers. Returns {story, alerts, recovered: text or null}.
 */
export function follow(story, alerts, now, unseen, patience = 0.1) {
  if (alerts.length > 0) {
    const began = story.since === null ? { since: now, unseen, told: null } : story;
    const tell = now - began.since >= patience;
    const told = tell ? alerts[0].key : began.told;
    return { story: { ...began, told }, alerts: tell || began.told ? alerts : [], recovered: null };
  }
  if (story.since === null) return { story: kWell, alerts: [], recovered: null };
  const recovered =
    story.told && story.told !== kConnecting
      ? `All is well again after ${duration(now - story.since)}; ${missed(unseen - story.unseen)}.`
      : null;
  return { story: kWell, alerts: [], recovered };
}

function missed(ticks) {
  return ticks > 0
    ? `${some(ticks, "tick")} in between ${ticks === 1 ? "was" : "were"} not seen`
    : "no tick was passed over";
}

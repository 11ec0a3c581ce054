// SPDX-License-Identifier: GPL-3.0-or-later
// The meaning of the numbers of proto/wire/wire.h, in sentences, and what to do. The one table of it.

/** ServoFlag by bit: [bit, short word, level, remedy]. Level: ok, note, warn or bad. */
export const kServoFlags = [
  [0, "contact", "ok", ""],
  [1, "waiting for contacts", "warn", "Contact has sent nothing yet. Large meshes take a moment."],
  [2, "holding", "note", "The contacts are older than expected; they are still rendered in full."],
  [3, "fading", "warn", "The contacts are stale and the force fades to zero. See the row of contact."],
  [4, "contacts stale", "bad", "The contacts are too old: nothing is rendered. See the log of hapticd."],
  [5, "reopening", "note", "Contacts are back; the force grows again."],
  [6, "saturated", "warn", "Force or torque is clipped to the limit. Press less, or lower the stiffness."],
  [7, "soft start", "note", "The force grows from zero."],
  [8, "FAULT", "bad", "The force is latched at zero. Mend the cause, then clear the fault."],
  [9, "clutched", "note", "The workspace is being moved; no force meanwhile."],
  [10, "paused", "note", "No force. “Resume” goes on."],
  [11, "solver limit", "warn", "The contacts contradict each other, or the solver ran out of steps."],
  [12, "no torque actuators", "note", "The device cannot exert torque; it is only shown."],
  [13, "stopped", "warn", "The servo has ended, with zero force."],
  [14, "not armed", "warn", "No force. Hold the dead-man button, or use “Arm”."],
  [15, "too fast", "bad", "The hand moved faster than the limit. Hold it still; the force comes back."],
  [16, "slewing", "note", "The growth of the force is limited."],
  [17, "motors warm", "warn", "The thermal budget of the motors lowers the limit. Let them rest."],
  [18, "damped to stay passive", "note", "The passivity controller damps. Lower the stiffness if it lasts."],
  [19, "edge of the workspace", "note", "The soft edge of the workspace pushes back."],
  [20, "device lost or not homed", "bad", "Plug the device in and calibrate it."],
  [21, "softened towards a light body", "note", "The body is too light for this stiffness. Lower it, or give the body more mass."],
  [22, "stiffer than the device holds", "warn", "It was forced, and may sing in a light hand. Lower the stiffness."],
  [23, "servo falls behind", "warn", "It skips ticks. Close other programs, or lower rate in [servo]."],
  [24, "contact falls behind", "warn", "Its contacts come late. Use smaller meshes, or a renderer that asks less."],
  [25, "sim falls behind", "warn", "It skips frames. Use fewer bodies, or lower rate in [sim]."],
  [26, "arm not held up", "bad", "It ran away by itself. Check [device.gravity], then take the handle."],
];

/** Fault by number: [sentence, remedy]. */
export const kFaults = [
  ["", ""],
  ["The device's sample was not finite.", "Check the device and its driver, then clear the fault."],
  ["The contacts or the poses of objects were not finite.", "Check the scene, then clear the fault."],
  ["The wanted force was not finite.", "Lower stiffness and damping, then clear the fault."],
  ["The wanted force was over a thousand times the limit.", "Lower the stiffness, then clear the fault."],
  ["The pose of the device jumped.", "Check cable and encoders, then clear the fault."],
  ["The device's answers do not match the requests (frozen, old, or of an arm that does not follow).",
    "Free the arm, or unplug the device and plug it in again, then clear the fault."],
  ["An encoder of the device is noisy.", "Check its cable and plug, then clear the fault."],
];

/** ContactFlag by bit: [bit, sentence, level]. */
export const kContactFlags = [
  [0, "The proxy was placed anew.", "note"],
  [1, "The contact search stopped at its limit of steps.", "warn"],
  [2, "There are more contacts than can be sent.", "warn"],
  [3, "No free place was found for the tool: nothing is felt.", "bad"],
  [5, "This renderer lacks its tool or its maps in this session.", "bad"],
  [6, "A client's wrench or planes are part of what is felt.", "note"],
];

// flags is a float64 with an integer below 2³²; & would take the sign from bit 31
const has = (flags, bit) => Math.floor(flags / 2 ** bit) % 2 === 1;

/** The short words of what the servo does now: [{word, level}]. */
export function state_words(flags) {
  return kServoFlags.filter(([bit]) => has(flags, bit)).map(([, word, level]) => ({ word, level }));
}

function servo_troubles(frame) {
  return kServoFlags
    .filter(([bit, , level]) => has(frame.flags, bit) && bit !== 8 && (level === "bad" || level === "warn"))
    .map(([, word, level, remedy]) => ({ text: sentence(word), remedy, level }));
}

/** Begins with a capital letter and ends with a stop. */
const sentence = (text) => `${text.charAt(0).toUpperCase()}${text.slice(1).replace(/\.$/, "")}.`;

/** What is wrong in a frame, worst first: [{text, remedy, level}]; empty where all is well. */
export function troubles(frame) {
  const list = [];
  if (has(frame.flags, 8) || frame.fault > 0) {
    const known = kFaults[frame.fault] ??
      [`Fault ${frame.fault}, unknown to this page.`, "See the log of hapticd."];
    list.push({ text: known[0] || kFaultWithoutReason, remedy: known[1] || kFaultRemedy, level: "bad" });
  }
  list.push(...servo_troubles(frame));
  for (const [bit, text, level] of kContactFlags) {
    if (level !== "note" && has(frame.contact_flags, bit)) list.push({ text, remedy: "", level });
  }
  const rank = { bad: 0, warn: 1 };
  return list.sort((a, b) => rank[a.level] - rank[b.level]);
}

const kFaultWithoutReason = "A fault is latched.";
const kFaultRemedy = "Mend the cause, then clear the fault.";

const with_level = (texts, level) =>
  (texts ?? []).map(({ text, remedy }) => ({ text: sentence(text), remedy: remedy ?? "", level }));

/** The troubles to show: the faults that the bridge tells in its status, else those of the frame,
    then what it warns of. */
export function shown_troubles(status, frame) {
  const warnings = with_level(status?.warnings, "warn");
  if (status?.faults?.length > 0) {
    // they have no level of their own: a pause is no failure
    const level = !frame || troubles(frame).some((trouble) => trouble.level === "bad") ? "bad" : "warn";
    return [...with_level(status.faults, level), ...warnings];
  }
  return [...(frame ? troubles(frame) : []), ...warnings];
}

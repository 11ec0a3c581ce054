// SPDX-License-Identifier: GPL-3.0-or-later
// A tool that strokes a ball, as a function of the tick: what the mock bridge shows.

export const kRadius = 0.03; // [m] of the ball
const kStiffness = 600; // [N/m]
export const kPeriod = 0.001; // [s]
export const kContactFlag = 1;
export const kFaultFlag = 256;

/** The hand at a time: circles over the ball, in and out of it; a column is a little apart. */
function hand_at(time, column) {
  const turn = 0.8 * time;
  const away = kRadius + 0.004 * Math.sin(2.1 * time + 0.3 * column) - 0.001 * (column + 1);
  const tilt = 0.75 + 0.2 * Math.sin(0.5 * time);
  return [Math.sin(tilt) * Math.cos(turn), Math.cos(tilt), Math.sin(tilt) * Math.sin(turn)].map(
    (value) => value * away,
  );
}

/** Proxy, force and contact of a hand. */
function feel(hand, stiffness) {
  const far = Math.hypot(...hand);
  const normal = hand.map((value) => value / far);
  const depth = Math.max(kRadius - far, 0);
  const proxy = depth > 0 ? normal.map((value) => value * kRadius) : hand;
  const force = normal.map((value) => value * depth * stiffness);
  return { proxy, normal, depth, force };
}

const pose = (p) => [...p, 1, 0, 0, 0];

export const is_late = (tick) => tick % 4001 === 0;
export const is_faulted = (tick) => tick % 9000 >= 8000;

/** One servo tick: what a sample of it says. `led` is the intent's hand, or null. */
export function tick_at(tick, column, { led = null, stiffness = kStiffness, faults = false } = {}) {
  const time = tick * kPeriod;
  const hand = led ?? hand_at(time, column);
  const touch = feel(hand, stiffness);
  const fault = faults && is_faulted(tick);
  if (fault) touch.force = [0, 0, 0];
  const flags = (touch.depth > 0 ? kContactFlag : 0) + (fault ? kFaultFlag : 0);
  const torque = [0.02 * touch.force[2], 0, -0.02 * touch.force[0]];
  const noise = Math.abs((Math.sin(tick * 12.9898) * 43758.5453) % 1);
  return {
    time,
    hand,
    ...touch,
    torque,
    flags,
    fault: fault ? 5 : 0,
    wake_late: 4e-6 + 1.5e-5 * noise + (is_late(tick) ? 4e-4 : 0),
    contact_rate: 940 + 40 * noise,
  };
}

/** A frame of the bridge: the fixed part of `tick` and the samples since `since`. */
export function frame_at(tick, since, column, options) {
  const now = tick_at(tick, column, options);
  const samples = [];
  for (let t = Math.max(since + 1, tick - 255, 0); t <= tick; t += 1)
    samples.push(tick_at(t, column, options));
  const contacts =
    now.depth > -1 && Math.hypot(...now.hand) < kRadius + 0.004
      ? [
          {
            point: now.normal.map((v) => v * kRadius),
            normal: now.normal,
            extent: 0.006,
            object: 0,
            active: now.depth > 0 ? 1 : 0,
          },
          {
            point: tilted(now.normal).map((v) => v * kRadius),
            normal: tilted(now.normal),
            extent: 0.003,
            object: 0,
            active: 0,
          },
        ]
      : [];
  return {
    column,
    tick,
    time: now.time,
    realtime: 1.8e9 + now.time,
    tool: pose(now.hand),
    proxy: pose(now.proxy),
    verified: pose(now.proxy),
    handle: pose(now.hand),
    velocity: [0.01, 0.02, 0.005, 0, 0, 0],
    force: now.force,
    torque: now.torque,
    coupling_force: now.force,
    coupling_torque: now.torque,
    depth: now.depth,
    fade: 1,
    flags: now.flags,
    fault: now.fault,
    wake_late: now.wake_late,
    busy: 2.1e-5,
    n_pushing: now.depth > 0 ? 1 : 0,
    contact_age: 0.001,
    contact_busy: 3e-4,
    age_servo: 0.0012,
    age_contact: 0.0021,
    age_sim: 0.006,
    rate_servo: 1000,
    rate_contact: 958,
    rate_sim: 120,
    revision: 3,
    stiffness: options?.stiffness ?? kStiffness,
    damping: 1,
    armed: 1,
    objects: [
      { pose: pose([0, 0, 0]) },
      { pose: pose([0.05 + 0.006 * Math.sin(0.7 * now.time), 0.008, 0.012]) },
    ],
    contacts,
    samples,
  };
}

function tilted(n) {
  const v = [n[0] + 0.18, n[1], n[2] - 0.12];
  const size = Math.hypot(...v);
  return v.map((value) => value / size);
}

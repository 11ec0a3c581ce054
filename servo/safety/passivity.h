// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/math/vec3.h"

namespace haptic {

/// Energy below zero that is let pass before the controller acts [J]: quantised positions and the
/// noise of a hand make a passive wall look active by less than this.
inline constexpr double kPassivitySlack = 1e-3;
/// The largest deficit that is kept for later [J]: what a damper could not pay at once.
inline constexpr double kPassivityDebt = 50e-3;

/// Energy the hand has put into the port since contact began, minus what it got back [J].
struct PassivityState {
  double energy = 0;
  Vec3 p_B;            // handle at the last sample [m]
  int64_t t_ns = 0;    // and its instant
  Vec3 impulse_B;      // of the force on the hand since then [N·s]
  double held = 0;     // over this time [s]
  bool known = false;  // all of them
};

struct PassivityInput {
  Vec3 p_B;                 // handle at the newest sample [m]
  int64_t t_ns = 0;         // and its instant; not later than the last one's: there was no new one
  Vec3 surface_velocity_B;  // of what is touched: the work of a moving object is its own [m/s]
  Vec3 force_B;             // that is to be held over the coming tick [N]
  double max_damping = 0;   // the damper's bound: what the device renders stably [N·s/m]
};

struct PassivityOutput {
  Vec3 force_B;
  bool damped = false;  // the controller acted
};

/// Passivity observer and controller at the port between hand and device, in device units. At each
/// new sample, with Δx the way of the handle since the last one, less that of the surface, Δt the
/// time between them (at least dt) and v = Δx/Δt:
///   E −= F_held · Δx,  F_held the force that was held over that time;
///   where E − F·v dt falls below −slack, the damper F_pc = −α v along F (after the last push:
///   along F_held) pays it back, α = deficit / (dt v²) ≤ max_damping. It pulls no more than the
///   larger of F and F_held, so behind a wall that is left it only dies away.
/// Pairing F_k with the step before it, x_k − x_{k−1}, would show the energy that sampling adds
/// with the wrong sign: a leaking wall would look dissipative. In free space what the hand has put
/// in is forgotten at once, a debt over half a second: a wall that is hopped on adds its leaks up.
/// Source: Hannaford & Ryu, "Time-domain passivity control of haptic interfaces", T-RA 18(1), 2002.
PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt);

/// After all limits: the force that is really held over the coming tick.
void note_held(PassivityState& state, const Vec3& held_B, double dt);

}  // namespace haptic

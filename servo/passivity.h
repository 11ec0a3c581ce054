// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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
  Vec3 held_B;         // force on the hand over the tick that ends now [N]
  Vec3 p_B;            // handle at the beginning of that tick [m]
  bool known = false;  // both of them
};

struct PassivityInput {
  Vec3 p_B;                 // handle now [m]
  Vec3 surface_velocity_B;  // of what is touched: the work of a moving object is its own [m/s]
  Vec3 force_B;             // that is to be held over the coming tick [N]
  double max_damping = 0;   // the damper's bound: what the device renders stably [N·s/m]
};

struct PassivityOutput {
  Vec3 force_B;
  bool damped = false;  // the controller acted
};

/// Passivity observer and controller at the port between hand and device, in device units:
///   E += −F_held · Δx + b |Δx|²/dt,  Δx the way of the handle over the tick in which F_held was
///   held, less that of the surface; b the damping of the device itself;  where E − F·Δx falls
///   below −slack the damper F_pc = −α v, v = Δx/dt along F (in the one tick after the last push:
///   along F_held), α = deficit / (dt v²) ≤ max_damping, pays it back.
/// Pairing F_k with the step before it, x_k − x_{k−1}, would show the energy that sampling adds
/// with the wrong sign: a leaking wall would look dissipative. In free space what the hand has put
/// in is forgotten at once, a debt over half a second: a wall that is hopped on adds its leaks up.
/// Source: Hannaford & Ryu, "Time-domain passivity control of haptic interfaces", T-RA 18(1), 2002.
PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt);

/// After all limits: the force that is really held from now on.
void note_held(PassivityState& state, const Vec3& p_B, const Vec3& held_B);

}  // namespace haptic

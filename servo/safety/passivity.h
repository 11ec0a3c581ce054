// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/math/pose.h"

namespace haptic {

/// Deficit of energy at which the controller begins to act [J]. Quantised positions and the noise
/// of a hand make a passive wall look active by less than this.
inline constexpr double kPassivitySlack = 1e-3;
/// Largest deficit that is carried over [J]: what the damper could not dissipate at once.
inline constexpr double kPassivityDebt = 50e-3;

/// Energy the hand has put into the port since contact began, minus the energy it got back [J].
struct PassivityState {
  double energy = 0;   // of force and torque together
  double turning = 0;  // the part of it that torque and turning have made
  Pose X_BH;           // handle at the last sample
  int64_t t_ns = 0;    // its instant
  Wrench impulse_B;    // of the wrench on the hand since that sample [N·s, N·m·s]
  double held = 0;     // duration of that impulse [s]
  bool known = false;  // false: no sample yet
};

struct PassivityInput {
  Pose X_BH;                          // handle at the newest sample
  int64_t t_ns = 0;                   // its instant; not later than the previous one: no new sample
  Twist surface_B;                    // of the touched surface: a moving object's work is its own
  Wrench F_B;                         // to be held over the coming tick
  double max_damping = 0;             // bound of α: what the device renders stably [N·s/m]
  double max_rotational_damping = 0;  // the same for turning [N·m·s/rad]
};

struct PassivityOutput {
  Wrench F_B;
  bool damped = false;  // the controller acted
};

/// Passivity observer and controller at the port between hand and device, in device units. At each
/// new sample, Δx is the displacement of the handle since the last one relative to the surface, Δθ
/// its rotation vector in B, Δt the time between them (at least dt), v = Δx/Δt and ω = Δθ/Δt:
///
/// observer: E −= f_held · Δx + τ_held · Δθ, with the wrench held over that time.
///
/// controller: where E − (f·v + τ·ω) dt < −slack, a damper dissipates the deficit. The deficit is
/// paid where it arose: force and torque have ledgers of their own, which sum up to E, and it is
/// divided among those that are negative in proportion. For the force, f_pc = −α v along f (or
/// along f_held, if f is zero), α = deficit / (dt v²) ≤ max_damping, and |f_pc| is at most the
/// larger of |f| and |f_held|, so the force only decays once the hand has left the wall. The torque
/// likewise, with ω and max_rotational_damping.
///
/// Pairing F_k with the step before it, x_k − x_{k−1}, would give the energy that sampling adds the
/// wrong sign: an active wall would look dissipative. In free space a surplus is dropped at once
/// and a deficit decays over half a second, so that the leaks of a wall that is tapped repeatedly
/// add up. Source: Hannaford & Ryu 2002.
PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt);

/// Notes the wrench that is held over the coming tick, after all limits.
void note_held(PassivityState& state, const Wrench& held_B, double dt);

}  // namespace haptic

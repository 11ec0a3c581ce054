// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/math/vec3.h"

namespace haptic {

/// Deficit of energy at which the controller begins to act [J]. Quantised positions and the noise
/// of a hand make a passive wall look active by less than this.
inline constexpr double kPassivitySlack = 1e-3;
/// Largest deficit that is carried over [J]: what the damper could not dissipate at once.
inline constexpr double kPassivityDebt = 50e-3;

/// Energy the hand has put into the port since contact began, minus the energy it got back [J].
struct PassivityState {
  double energy = 0;
  Vec3 p_B;            // handle at the last sample [m]
  int64_t t_ns = 0;    // its instant
  Vec3 impulse_B;      // of the force on the hand since that sample [N·s]
  double held = 0;     // duration of that impulse [s]
  bool known = false;  // false: no sample yet
};

struct PassivityInput {
  Vec3 p_B;                 // handle at the newest sample [m]
  int64_t t_ns = 0;         // its instant; not later than the previous one: no new sample
  Vec3 surface_velocity_B;  // of the touched surface: the work of a moving object is its own [m/s]
  Vec3 force_B;             // to be held over the coming tick [N]
  double max_damping = 0;   // bound of α: what the device renders stably [N·s/m]
};

struct PassivityOutput {
  Vec3 force_B;
  bool damped = false;  // the controller acted
};

/// Passivity observer and controller at the port between hand and device, in device units. At each
/// new sample, Δx is the displacement of the handle since the last one relative to the surface, Δt
/// the time between them (at least dt), and v = Δx/Δt:
///
/// observer: E −= F_held · Δx, F_held the force held over that time.
///
/// controller: where E − F·v dt < −slack, a damper F_pc = −α v along F (or along F_held, if F is
/// zero) dissipates the deficit; α = deficit / (dt v²) ≤ max_damping. |F_pc| is at most the larger
/// of |F| and |F_held|, so the force only decays once the hand has left the wall.
///
/// Pairing F_k with the step before it, x_k − x_{k−1}, would give the energy that sampling adds the
/// wrong sign: an active wall would look dissipative. In free space a surplus is dropped at once
/// and a deficit decays over half a second, so that the leaks of a wall that is tapped repeatedly
/// add up. Source: Hannaford & Ryu 2002.
PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt);

/// Notes the force that is held over the coming tick, after all limits.
void note_held(PassivityState& state, const Vec3& held_B, double dt);

}  // namespace haptic

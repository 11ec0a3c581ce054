// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <vector>

#include "device-io/hand/impedance.h"
#include "device-io/hand/plant.h"
#include "proto/config/config.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

// one stroke: reach and slide, then the intention stands still, then it lifts
inline constexpr double kStroke = 1, kStandsFrom = 0.75 * kStroke, kHeld = 1;  // [s]
inline constexpr size_t kTicks = 2100, kSecond = 1000;

/// The seeded motion, which pauses in the middle of its first stroke, pressed in and turned.
inline Intention pausing(const SimulatedHandConfig& config) {
  return [own = seeded_intention(config)](double t) {
    if (t >= kStandsFrom + kHeld) return own(t - kHeld);
    if (t < kStandsFrom) return own(t);
    Intent still = own(kStandsFrom);
    still.v_B = still.w_B = {};
    return still;
  };
}

/// Until a tick.
struct Account {
  double given = 0;   // by the motors, less what the handle's friction and damping took [J]
  double stored = 0;  // in the springs of the coupling, by the wrench that the motors hold [J]
};

/// A coupling without a turning spring holds nothing in it.
inline double stored_in(const Coupling& k, const Wrench& F) {
  const double moving = norm_squared(F.f) / (2 * k.translational_stiffness);
  if (k.rotational_stiffness == 0) return moving;
  return moving + norm_squared(F.t) / (2 * k.rotational_stiffness);
}

inline double kinetic_energy(const SimulatedHandConfig& c, const HandPlant& plant) {
  return ((c.mass + c.hand_mass) * norm_squared(plant.v_B) +
          (c.inertia + c.hand_inertia) * norm_squared(plant.w_B)) /
         2;
}

/// Figures of a run.
struct Run {
  std::vector<Account> accounts;
  std::vector<double> kinetic;   // of handle and hand [J]
  size_t touching = 0;           // ticks
  double force = 0, torque = 0;  // the largest

  /// After a tick: what a plant of this hand has been given, less what shook it [J].
  void note(const SessionConfig& session, const SimulatedHandConfig& hand, const HandPlant& plant,
            const ServoFrame& frame, double shaken = 0) {
    const Wrench& told = frame.F_device_B;
    accounts.push_back({plant.energy.device_work - shaken - plant.energy.device_loss,
                        stored_in(session.coupling, told)});
    kinetic.push_back(kinetic_energy(hand, plant));
    touching += (frame.flags & kServoContact) != 0;
    force = std::max(force, norm(told.f));
    torque = std::max(torque, norm(told.t));
  }
};

/// All five hands by HAPTIC_TORTURE_SCALE=2, in CI the lightest that holds.
inline std::vector<HandImpedance> played_hands() {
  if (torture_scale() > 1) return {kHandImpedances.begin(), kHandImpedances.end()};
  return {kHandImpedances[1]};
}

/// The handle under a hand that strokes without a tremor.
inline void put_under(SimulatedHandConfig& handle, const HandImpedance& hand) {
  put_into_hand(hand, handle);
  handle.intent.stroke_time = kStroke;
  handle.intent.tremor_amplitude = 0;
}

/// Largest kinetic energy in that eighth of the second in which the intention stands still [J].
inline double largest_kinetic(const Run& run, size_t eighth) {
  const auto from = run.kinetic.begin() + static_cast<ptrdiff_t>(kStandsFrom * kSecond) +
                    static_cast<ptrdiff_t>(125 * eighth);
  return *std::max_element(from, from + 125);
}

/// The most that a second gave the hand beyond what it had put in, before or in that second [J].
inline double gained(const Run& run) {
  double most = -1;
  for (size_t k = 0; k + kSecond < kTicks; ++k) {
    const Account &begin = run.accounts[k], &end = run.accounts[k + kSecond];
    most = std::max(most, end.given - begin.given - begin.stored);
  }
  return most;
}

}  // namespace haptic::test

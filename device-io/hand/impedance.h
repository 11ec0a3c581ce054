// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string_view>

#include "proto/config/config.h"

namespace haptic {

/// A hand holding a device: mass, damper and spring towards the intended position, and the same
/// towards the intended orientation.
struct HandImpedance {
  std::string_view name;
  double mass;                  // [kg]
  double damping;               // [N·s/m]
  double stiffness;             // [N/m]
  double inertia;               // [kg·m²]
  double rotational_damping;    // [N·m·s/rad]
  double rotational_stiffness;  // [N·m/rad]
};

/// A test grid from no hand to a stiff arm, not measured persons; the model is that of Hogan 1989,
/// with values that grow with the grip (Kuchenbecker et al. 2003; Hasser & Cutkosky 2002). Those of
/// turning are guesses: a wrist at rest has about one to three newton metres per radian, and the
/// rows have the frequencies (5 to 8 Hz) and the damping ratios (0.2 to 0.35) that go with it.
inline constexpr std::array<HandImpedance, 5> kHandImpedances{{
    {"none", 0, 0, 0, 0, 0, 0},
    {"light-grip", 0.1, 2, 100, 2e-4, 7e-3, 0.5},
    {"typical", 0.5, 5, 300, 1e-3, 0.02, 2},
    {"firm", 1.5, 12, 600, 3e-3, 0.05, 5},
    {"stiff-arm", 3.0, 20, 1000, 6e-3, 0.1, 10},
}};

/// The hand of that name; null if there is none.
inline const HandImpedance* find_hand(std::string_view name) {
  for (const HandImpedance& hand : kHandImpedances) {
    if (hand.name == name) return &hand;
  }
  return nullptr;
}

inline void put_into_hand(const HandImpedance& hand, SimulatedHandConfig& config) {
  config.hand_mass = hand.mass;
  config.hand_damping = hand.damping;
  config.hand_stiffness = hand.stiffness;
  config.hand_inertia = hand.inertia;
  config.hand_rotational_damping = hand.rotational_damping;
  config.hand_rotational_stiffness = hand.rotational_stiffness;
}

}  // namespace haptic

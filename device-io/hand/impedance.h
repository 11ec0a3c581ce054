// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string_view>

#include "proto/config/config.h"

namespace haptic {

/// A hand holding a device: mass, damper and spring towards the intended position.
struct HandImpedance {
  std::string_view name;
  double mass;       // [kg]
  double damping;    // [N·s/m]
  double stiffness;  // [N/m]
};

/// A test grid from no hand to a stiff arm, not measured persons; the model is that of Hogan 1989,
/// with values that grow with the grip (Kuchenbecker et al. 2003; Hasser & Cutkosky 2002).
inline constexpr std::array<HandImpedance, 5> kHandImpedances{{
    {"none", 0, 0, 0},
    {"light-grip", 0.1, 2, 100},
    {"typical", 0.5, 5, 300},
    {"firm", 1.5, 12, 600},
    {"stiff-arm", 3.0, 20, 1000},
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
}

}  // namespace haptic

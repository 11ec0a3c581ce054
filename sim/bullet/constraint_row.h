// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/math/pose.h"

namespace haptic {

inline constexpr uint32_t kNoMass = ~0u;

/// κ of the penalty that holds what rows hold, over the heaviest mass: to one in a million.
inline constexpr double kHold = 1e6;

/// A direction in which a constraint lets nothing move: row_a · V_a + row_b · V_b = 0, with the
/// twists of the centres of mass in W.
struct ConstraintRow {
  uint32_t a = kNoMass, b = kNoMass;  // objects; kNoMass: nothing with mass
  Twist row_a, row_b;
};

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace haptic {

inline constexpr double kMinReach = 0.2e-3;       // look-ahead of a resting point [m]
inline constexpr double kLeastBodyReach = 20e-6;  // of a body [m]
inline constexpr double kMaxReach = 20e-3;        // bound of the look-ahead's cost [m]

/// How far contact looks ahead from where the tool will be when its answer is used [m]: as far as
/// it may come before the next two answers, at that speed [m/s] and with that time between two
/// answers [s]. An admittance device goes nowhere that nobody has looked at, so contact looks twice
/// as far for it (servo/admittance/seen_space.h).
inline double look_ahead_reach(double speed, double period, double servo_period, bool is_body,
                               bool is_admittance) {
  const double reach = std::max(speed * (2 * period + servo_period),
                                is_body && !is_admittance ? kLeastBodyReach : kMinReach);
  return std::min(is_admittance ? 2 * reach : reach, kMaxReach);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/assert.h"
#include "proto/math/quat.h"

namespace haptic {

/// Intended motion of a hand, in the device's base frame.
struct Intent {
  Vec3 p_B;    // [m]
  Vec3 v_B;    // [m/s], the derivative of p_B
  Quat q_B{};  // of the handle
  Vec3 w_B{};  // angular velocity of q_B [rad/s]
};

/// How far along a motion, 0 to 1, and its rate [1/s].
struct IntentProgress {
  double s, rate;
};

/// From rest to rest with the least jerk: s = 10τ³ − 15τ⁴ + 6τ⁵ (Flash & Hogan 1985), τ the
/// fraction of the duration [s].
inline IntentProgress minimum_jerk(double fraction, double duration) {
  HAPTIC_ASSERT(fraction >= 0 && fraction <= 1 && duration > 0);
  const double a = fraction, b = 1 - fraction;
  return {a * a * a * (10 + a * (6 * a - 15)), 30 * a * a * b * b / duration};
}

}  // namespace haptic

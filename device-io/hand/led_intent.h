// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "device-io/hand/intent.h"
#include "proto/math/pose.h"

namespace haptic {

/// Rate of the filter that makes a motion of the commands [1/s]. Steps at 60 Hz are damped to
/// 1/(1 + (2π·60/ω)²) = 0.6 %, and the intent lags 2/ω = 67 ms behind, a third of the delay with
/// which a person corrects a movement by sight.
inline constexpr double kLedRate = 30;

/// Largest speed of the led intent, relative to where it is led [m/s]: that of a quick reach, and a
/// quarter of the velocity limit beyond which safety closes the force.
inline constexpr double kMostLedSpeed = 0.5;

/// Largest speed of turning [rad/s]: a quarter of the limit of angular velocity.
inline constexpr double kMostLedSpin = 5;

/// A place in B within which a hand can be led.
struct Ball {
  Vec3 centre_B;
  double radius = 0;  // [m]
};
Vec3 nearest_in(const Ball& ball, const Vec3& p_B);

/// A quantity that follows its reference: its offset from it, d, dies out like a critically damped
/// spring, d̈ = −2ω ḋ − ω² d, ω = kLedRate.
struct LedOffset {
  Vec3 value;  // d [m or rad]
  Vec3 rate;   // ḋ [m/s or rad/s]
};

/// The intent of a hand that is led, or on its way back to its own motion: x = r + d with the
/// reference r, the pose it is led to or its own motion. Of the orientation d is the rotation
/// vector from the reference, q = exp(d) q_r. A new reference changes d and ḋ such that pose and
/// velocity stay: the intent is C¹ whatever the commands, at their begin and end too. The response
/// to a step is never negative, so from rest the position stays in the convex hull of the places it
/// is led to, and a turn goes by the shorter arc and never past its end.
struct LedIntent {
  bool is_away = false;          // from its own motion
  std::optional<Pose> target_B;  // none: its own motion
  LedOffset way_B, turn_B;
};

/// Another reference from now on; `own` is the hand's own motion now.
void retarget(LedIntent& led, const std::optional<Pose>& target_B, const Intent& own);

/// The intent after h seconds more, where the reference will then be at X_B. Implicit Euler: it
/// never overshoots at any step, and needs exactly rounded operations only. The hand is back in its
/// own motion when it is a nanometre and a nanoradian away.
Pose follow(LedIntent& led, const Pose& X_B, double h);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/led_intent.h"

#include <algorithm>

#include "device-io/hand/portable_turn.h"
#include "device-io/sensing/saturate.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kBack = 1e-9;  // offset [m, rad] and rate [m/s, rad/s] that are none

Intent reference(const LedIntent& led, const Intent& own) {
  return led.target_B ? Intent{led.target_B->p, {}, led.target_B->q, {}} : own;
}

/// The offset from the reference `now` that leaves orientation and angular velocity as they were
/// with the offset `turn` from `before`.
LedOffset turn_from(const LedOffset& turn, const Intent& before, const Intent& now) {
  const Quat q_offset = portable_turn(turn.value);
  const Vec3 w_B = angular_velocity_of(turn.value, turn.rate) + rotate(q_offset, before.w_B);
  const Quat q_new = q_offset * before.q_B * conjugate(now.q_B);
  const Vec3 value = portable_rotation_vector(q_new);
  return {value, rotation_vector_rate(value, w_B - rotate(q_new, now.w_B))};
}

/// One step of the spring, its rate bounded.
void relax(LedOffset& offset, double most, double h) {
  // a hand that was faster when it was led is not braked at once
  most = std::max(most, norm(offset.rate));
  const double grown = 1 + h * kLedRate;
  offset.rate = (offset.rate - h * kLedRate * kLedRate * offset.value) / (grown * grown);
  saturate(offset.rate, most);
  offset.value += h * offset.rate;
}

bool is_over(const LedOffset& offset) {
  return norm(offset.value) < kBack && norm(offset.rate) < kBack;
}

}  // namespace

Vec3 nearest_in(const Ball& ball, const Vec3& p_B) {
  Vec3 way_B = p_B - ball.centre_B;
  return saturate(way_B, ball.radius) ? ball.centre_B + way_B : p_B;
}

void retarget(LedIntent& led, const std::optional<Pose>& target_B, const Intent& own) {
  const Intent before = reference(led, own);
  led.target_B = target_B;
  led.is_away = true;
  const Intent now = reference(led, own);
  led.way_B.value += before.p_B - now.p_B;
  led.way_B.rate += before.v_B - now.v_B;
  led.turn_B = turn_from(led.turn_B, before, now);
}

Pose follow(LedIntent& led, const Pose& X_B, double h) {
  HAPTIC_ASSERT(h > 0);
  relax(led.way_B, kMostLedSpeed, h);
  relax(led.turn_B, kMostLedSpin, h);
  const bool is_back = !led.target_B && is_over(led.way_B) && is_over(led.turn_B);
  if (is_back) led = {};
  return {X_B.p + led.way_B.value, normalized(portable_turn(led.turn_B.value) * X_B.q)};
}

}  // namespace haptic

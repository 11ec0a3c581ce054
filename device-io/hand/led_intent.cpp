// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/led_intent.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kBack = 1e-9;  // offset [m] and rate [m/s] that are none

Intent reference(const LedIntent& led, const Intent& own) {
  return led.target_B ? Intent{*led.target_B, {}} : own;
}

}  // namespace

Vec3 nearest_in(const Ball& ball, const Vec3& p_B) {
  const Vec3 way_B = p_B - ball.centre_B;
  const double far = norm(way_B);
  return far > ball.radius ? ball.centre_B + ball.radius / far * way_B : p_B;
}

void retarget(LedIntent& led, const std::optional<Vec3>& target_B, const Intent& own) {
  const Intent before = reference(led, own);
  led.target_B = target_B;
  led.is_away = true;
  const Intent now = reference(led, own);
  led.offset_B += before.p_B - now.p_B;
  led.rate_B += before.v_B - now.v_B;
}

Vec3 follow(LedIntent& led, const Vec3& r_B, double h) {
  HAPTIC_ASSERT(h > 0);
  // a hand that was faster when it was led is not braked at once
  const double most = std::max(kMostLedSpeed, norm(led.rate_B));
  const double grown = 1 + h * kLedRate;
  led.rate_B = (led.rate_B - h * kLedRate * kLedRate * led.offset_B) / (grown * grown);
  const double speed = norm(led.rate_B);
  if (speed > most) led.rate_B *= most / speed;
  led.offset_B += h * led.rate_B;
  const bool is_back = !led.target_B && norm(led.offset_B) < kBack && norm(led.rate_B) < kBack;
  if (is_back) led = {};
  return r_B + led.offset_B;
}

}  // namespace haptic

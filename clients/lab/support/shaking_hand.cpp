// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/shaking_hand.h"

#include <algorithm>
#include <cmath>

#include "clients/lab/support/dice.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr double kTopSpeed = 0.5;    // [m/s]
constexpr int kSpeedTicks = 60'000;  // ticks over which the top speed is measured

}  // namespace

ShakingHand::ShakingHand(const Pose& home, const Shaking& shaking, uint64_t seed) : home_(home) {
  home_.p += shaking.press;
  Dice dice(seed);
  for (size_t axis = 0; axis < 6; ++axis) {
    const auto i = static_cast<int>(axis % 3);
    const double most = axis < 3 ? shaking.way[i] : shaking.turn[i];
    for (Sine& s : sines_[axis]) {
      s.amplitude = most / kSines;
      s.rate = 2 * kPi * dice.uniform(0.5, 8);
      s.phase = dice.uniform(0, 2 * kPi);
    }
  }
  for (int k = 0; k < kSpeedTicks; ++k) {
    const Vec3 way = at(kTick * (k + 1)).p - at(kTick * k).p;
    top_speed_ = std::max(top_speed_, norm(way) / kTick);
  }
  if (top_speed_ > kTopSpeed) pace_ = kTopSpeed / top_speed_;
  top_speed_ *= pace_;
}

double ShakingHand::swing(size_t axis, double t) const {
  double sum = 0;
  for (const Sine& s : sines_[axis]) sum += s.amplitude * std::sin(s.rate * t + s.phase);
  return sum;
}

Pose ShakingHand::at(double t) const {
  const double s = pace_ * t;
  const Vec3 way{swing(0, s), swing(1, s), swing(2, s)};
  const Vec3 turn{swing(3, s), swing(4, s), swing(5, s)};
  return {home_.p + way, normalized(from_rotation_vector(turn) * home_.q)};
}

}  // namespace haptic

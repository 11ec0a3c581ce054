// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/math/pose.h"

namespace haptic {

/// How far a hand goes, at most.
struct Shaking {
  Vec3 way;    // along each axis [m]
  Vec3 turn;   // about each [rad]
  Vec3 press;  // from home to the middle of its ways [m]
};

/// A hand that shakes whatever it feels: a sum of sines with random phases and frequencies of 0.5
/// to 8 Hz along and about each axis, all slowed down where it would be faster than 0.5 m/s.
class ShakingHand {
 public:
  ShakingHand(const Pose& home, const Shaking& shaking, uint64_t seed);

  Pose at(double t) const;                         // [s]
  double top_speed() const { return top_speed_; }  // in the first minute [m/s]

 private:
  struct Sine {
    double amplitude, rate, phase;
  };
  static constexpr size_t kSines = 5;
  double swing(size_t axis, double t) const;

  Pose home_;
  std::array<std::array<Sine, kSines>, 6> sines_{};
  double pace_ = 1, top_speed_ = 0;
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/math/pose.h"

namespace haptic {

/// Largest excursions of a hand.
struct Shaking {
  Vec3 way;    // amplitude along each axis [m]
  Vec3 turn;   // amplitude about each axis [rad]
  Vec3 press;  // from home to the centre of the motion [m]
};

/// A hand that shakes regardless of force: per axis a sum of sines in translation and in rotation
/// with random phases and frequencies of 0.5 to 8 Hz, slowed down as a whole to at most 0.5 m/s.
class ShakingHand {
 public:
  ShakingHand(const Pose& home, const Shaking& shaking, uint64_t seed);

  Pose at(double t) const;                         // [s]
  double top_speed() const { return top_speed_; }  // within the first minute [m/s]

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

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "proto/math/pose.h"

namespace haptic {

/// The path of an arm that follows its commands exactly, after a delay: on straight lines, turning
/// at a constant rate, from each commanded pose to the next. Keeps the last kRoom of them.
class ArmPath {
 public:
  explicit ArmPath(int64_t delay_ns) : delay_ns_(delay_ns) {}

  /// Rests at this pose, whatever was commanded before.
  void rest_at(const Pose& X_B);
  /// At t_ns the commanded motion leaves where it then is for this pose, which it reaches at
  /// arrival_ns > t_ns. t_ns is not before that of the last call.
  void go(int64_t t_ns, int64_t arrival_ns, const Pose& X_B);
  int64_t delay_ns() const { return delay_ns_; }
  /// The pose of the arm.
  Pose at(int64_t t_ns) const;

 private:
  static constexpr size_t kRoom = 1024;  // 50 ms of delay at 10 kHz, two knots a tick
  struct Knot {
    int64_t t_ns = 0;
    Pose X_B;
  };
  const Knot& back(size_t i) const { return knots_[(size_ - 1 - i) % kRoom]; }
  Pose commanded(int64_t then_ns) const;

  int64_t delay_ns_;
  std::array<Knot, kRoom> knots_{};
  size_t size_ = 1;  // all that were ever added
};

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/wire/wire.h"

namespace haptic {

/// The quantities of one servo tick that are plotted.
struct Sample {
  double time = 0;           // [s], of the session's clock
  Vec3 force_W, torque_W;    // at the device [N], [N·m]
  double depth = 0;          // [m]
  double wake_late = 0;      // [s]
  double contact_rate = 0;   // answers of contact a second, over the last 0.1 s
  uint32_t flags = 0;        // ServoFlag
  uint64_t contact_seq = 0;  // of the set in use
};

/// The newest samples, numbered from 0 on since the source began.
class Samples {
 public:
  static constexpr uint64_t kCapacity = 512;

  /// Appends one and gives it its contact_rate.
  void add(Sample sample);
  /// Samples since the source began; the newest has the number end() − 1.
  uint64_t end() const { return end_; }
  /// A sample of the newest kCapacity.
  const Sample& at(uint64_t number) const { return ring_[number % kCapacity]; }

 private:
  std::array<Sample, kCapacity> ring_{};
  uint64_t end_ = 0;
};

/// A sample of this frame; its contact_rate is given by Samples.
Sample sample_of(const ServoFrame& frame, const Pose& X_WB);

}  // namespace haptic

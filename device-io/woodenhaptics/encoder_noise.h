// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "device-io/woodenhaptics/kinematics.h"

namespace haptic {

/// Tells encoders that turn back and forth faster than a hand can from a hand.
///
/// Something that is accelerated by A at most and goes d1 one way within T1 and then d2 back within
/// T2 has min(d1, d2) <= A T1 T2 / 2: with the turn s after the middle sample,
/// d1 = A ((T1 + s)² − s²) / 2 and d2 = A ((T2 − s)² − s²) / 2, the smaller of the two is largest
/// at s = (T2 − T1) / 2. A sample whose turn is larger is *implausible*. How fast the hand is does
/// not matter, and when a sample was taken need be known no better than from question to answer: a
/// time that is taken too long allows more.
class EncoderNoise {
 public:
  /// A new sample, taken at some instant between the question and the answer [ns].
  void add(const MotorCounts& counts, int64_t asked_ns, int64_t heard_ns) noexcept;

  /// The path begins anew with the next sample.
  void restart() noexcept { started_ = false; }

  /// Eight samples were implausible, and not 32 times as many plausible in between; until so many
  /// were.
  bool is_noisy() const noexcept { return noisy_; }

 private:
  /// The last change of one encoder.
  struct Change {
    int32_t count = 0, step = 0;
    int64_t asked_ns = 0;  // of the sample with this count
    int64_t took_ns = 0;   // the step, at most
  };
  static bool turns_too_fast(Change& last, int32_t count, int64_t asked_ns, int64_t heard_ns);

  std::array<Change, 3> last_{};
  int doubt_ = 0;
  bool started_ = false, noisy_ = false;
};

}  // namespace haptic

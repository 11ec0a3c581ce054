// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "device-io/woodenhaptics/kinematics.h"

namespace haptic {

/// Detects encoders that reverse direction faster than a hand can.
///
/// A body accelerated by at most A that moves d1 one way within T1 and then d2 back within T2 has
/// min(d1, d2) ≤ A T1 T2 / 2: if it reverses at s after the middle sample, d1 = A ((T1 + s)² − s²)
/// / 2 and d2 = A ((T2 − s)² − s²) / 2, whose minimum is largest at s = (T2 − T1) / 2. A sample
/// that exceeds this is *implausible*. The speed of the hand is irrelevant, and the instant of a
/// sample need only be known to lie between question and answer: too long a time only raises the
/// bound.
class EncoderNoise {
 public:
  /// A new sample, taken between the question and the answer [ns].
  void add(const MotorCounts& counts, int64_t asked_ns, int64_t heard_ns) noexcept;

  /// The path starts anew with the next sample.
  void restart() noexcept { started_ = false; }

  /// Set by eight implausible samples, unless each is followed by 32 plausible ones; cleared by 256
  /// plausible ones.
  bool is_noisy() const noexcept { return noisy_; }

 private:
  /// The last change of one encoder.
  struct Change {
    int32_t count = 0, step = 0;
    int64_t asked_ns = 0;  // of the sample with this count
    int64_t took_ns = 0;   // upper bound of the duration of the step
  };
  static bool turns_too_fast(Change& last, int32_t count, int64_t asked_ns, int64_t heard_ns);

  std::array<Change, 3> last_{};
  int doubt_ = 0;
  bool started_ = false, noisy_ = false;
};

}  // namespace haptic

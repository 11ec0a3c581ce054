// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "device-io/sensing/motor_counts.h"
#include "device-io/sensing/trust.h"

namespace haptic {

/// A of the motors of an arm's tip [counts/ns²]: 100 m/s², where a count is at least 33 µm. Arms
/// reach half of that in a throw; a slap of 1.5 m/s on 1000 N/m with 0.25 kg is 95 m/s²; the motors
/// reach 5 N / 0.15 kg.
inline constexpr double kTipAcceleration = 3e-12;

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
  /// With A of each encoder [counts/ns²].
  explicit EncoderNoise(const std::array<double, kMostMotors>& most_acceleration)
      : most_acceleration_(most_acceleration) {}
  /// The noise of three motors that move a tip.
  EncoderNoise() : EncoderNoise({kTipAcceleration, kTipAcceleration, kTipAcceleration}) {}

  /// A new sample, taken between the question and the answer [ns].
  void add(const MotorCounts& counts, int64_t asked_ns, int64_t heard_ns) noexcept;

  /// The path starts anew with the next sample.
  void restart() noexcept { started_ = false; }

  /// Set by eight implausible samples, unless each is followed by 32 plausible ones; cleared by 256
  /// plausible ones.
  bool is_noisy() const noexcept { return trust_.is_lost(); }

 private:
  /// The last change of one encoder.
  struct Change {
    int32_t count = 0, step = 0;
    int64_t asked_ns = 0;  // of the sample with this count
    int64_t took_ns = 0;   // upper bound of the duration of the step
  };
  bool turns_too_fast(size_t i, int32_t count, int64_t asked_ns, int64_t heard_ns);

  std::array<double, kMostMotors> most_acceleration_;
  std::array<Change, kMostMotors> last_{};
  Trust trust_;
  bool started_ = false;
};

}  // namespace haptic

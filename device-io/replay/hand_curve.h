// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/log/hand_trace.h"

namespace haptic {

/// A recorded hand motion as a curve over the recording's time.
class HandCurve {
 public:
  /// Takes at least two samples, strictly increasing in time. Velocities missing in the recording
  /// (linear, angular, or both all zero) are computed from its poses.
  HandCurve(std::vector<DeviceState> samples, Resampling resampling, double max_gap);

  /// The state at t_ns; t_ns of the result is the instant of its pose.
  ///   - Within 1 µs of a sample: that sample, bit for bit.
  ///   - Between two samples, cubic: position by the Hermite cubic with the slopes of the parabola
  ///     through three neighbours (Catmull–Rom for unequal times, C¹), orientation by slerp, the
  ///     shorter way; twist the derivative of both; grip interpolated, buttons held.
  ///   - Between two samples, hold: the earlier one.
  ///   - In a gap longer than max_gap: its first sample at rest, kDeviceHeld.
  ///   - After the last sample: that one at rest, kDeviceHeld | kDeviceEnded.
  /// All others are kDeviceFresh; kDeviceHomed and kDeviceSimulated are as recorded.
  DeviceState at(int64_t t_ns) const;

  const std::vector<DeviceState>& samples() const { return samples_; }
  /// One line: rate, length, resampling and gaps of the recording.
  std::string description() const;

 private:
  size_t count_holes() const;
  bool is_hole(size_t i) const;
  double seconds(size_t i) const;
  Vec3 slope(size_t i, size_t of_interval) const;
  DeviceState between(size_t i, int64_t t_ns) const;
  void differentiate();

  std::vector<DeviceState> samples_;
  Resampling resampling_;
  int64_t max_gap_ns_;
};

}  // namespace haptic

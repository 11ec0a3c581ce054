// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Tolerance within which instants of two clocks count as equal [ns].
inline constexpr int64_t kSnapNs = 1000;

/// A measured motion of a hand: strictly increasing in time, at the recorded rate.
struct HandTrace {
  std::vector<DeviceState> samples;  // t_ns as in the file
  std::vector<uint64_t> ticks;       // of each sample; of a CSV without ticks its row, from zero
  std::string notice;                // TraceReader::notice; "": nothing to tell

  /// From the first sample to the last [s].
  double duration() const {
    if (samples.empty()) return 0;
    return static_cast<double>(samples.back().t_ns - samples.front().t_ns) * 1e-9;
  }
  /// From the first sample to the first one of this tick or a later one [s]; beyond the last: the
  /// duration.
  double time_of(uint64_t tick) const;
};

/// Loads the motion of `config.path`, depending on its contents:
///   - `.mcap`, or CSV with a column `device.t_ns`: a recording of this program, or its export;
///     only fresh samples are kept;
///   - `config.column` set: one degree of freedom, p_B = lever_arm · column · axis_B, with time in
///     `t_s`; without a lever arm the column is a length [m];
///   - else CSV with `t_s, x_m, y_m, z_m` and optionally the orientation `qx, qy, qz, qw` and the
///     `buttons` that are down, one bit each.
/// Velocities are those of the file, else zero: HandCurve in device-io differentiates. Throws
/// McapError, CsvError (file and line).
HandTrace load_hand_trace(const ReplayConfig& config);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

namespace haptic {

/// The differences of two recordings, tick by tick.
struct LogDiff {
  uint64_t common = 0;              // ticks that are in both
  uint64_t only_a = 0, only_b = 0;  // ticks that are in one
  uint64_t different = 0;           // of the common ones
  uint64_t first_tick = 0;          // that differs, if any does
  std::string first_field;          // of it, "X_WP.position.x"; where a tick lacks: "missing in A"
  double first_a = 0, first_b = 0;
  double rms_force = 0;  // of F_device_B(a) − F_device_B(b) over the common ticks [N]
  double rms_proxy = 0;  // of the proxy's position [m]

  bool is_equal() const { return different == 0 && only_a == 0 && only_b == 0; }
};

/// Compares the servo frames of two recordings, paired by their tick. Fields that say when the
/// machine did something (instants, lateness, computing times, which set came in time by number)
/// are compared only if `exact`; so two runs of one hand in lockstep are equal, whenever they ran.
/// `column`: of a comparison, by its name; empty: the first. Throws McapError.
LogDiff diff_logs(const std::string& a, const std::string& b, const std::string& column,
                  bool exact);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace haptic {

/// Pause before a process is started again after its n-th death in a row (n = 1, 2, …): none, 50
/// ms, 200 ms, then 1 s.
int64_t restart_delay_ns(int deaths_in_a_row);

/// A process that lived this long has recovered: its next death counts as the first.
inline constexpr int64_t kHealthyNs = 10'000'000'000;

/// What its heartbeat says about a running process.
enum class Pulse { kFine, kLate, kHung };

/// Late after 20 ms without a cycle (said), hung after 250 ms (killed and replaced; a host may hold
/// the machine up for 90 ms), both on top of the period of the loop.
Pulse judge_pulse(int64_t silent_ns, int64_t period_ns);

/// How long a process has been silent, without the times its observer was held up itself: a machine
/// that was asleep has not hung.
class Silence {
 public:
  /// One look at the heartbeat, held_up_ns later than it was to be. Returns the silence [ns] since
  /// beat_ns, less the lateness of this look and of every one before that found the same beat.
  int64_t look(uint64_t beat, int64_t beat_ns, int64_t t_ns, int64_t held_up_ns);

 private:
  uint64_t beat_ = 0;
  int64_t held_up_ns_ = 0;  // since that beat
};

}  // namespace haptic

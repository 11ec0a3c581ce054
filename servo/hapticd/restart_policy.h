// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/ipc/segment.h"

namespace haptic {

/// Delay before restarting a process after its n-th death in a row (n = 1, 2, …), of a life of
/// `lived_ns`: 0, 50 ms, 200 ms, then 1 s; but of a life of 200 ms and more at most a quarter of
/// it, so that whoever kills it at a steady rate leaves it four fifths of the time.
int64_t restart_delay_ns(int deaths_in_a_row, int64_t lived_ns);

/// Delay before restarting a spare, however long it lived: 1 s, doubled with each death up to 64 s,
/// because the cause of repeated deaths may pass.
int64_t spare_delay_ns(int deaths_in_a_row, int64_t lived_ns);

/// Uptime after which the next death counts as the first [ns].
inline constexpr int64_t kHealthyNs = 10'000'000'000;

/// True if the loop of that generation runs, by the header of its segment; null: it is not known
/// yet.
bool runs(const SegmentHeader* header, uint64_t generation) noexcept;

/// State of a running process by its heartbeat.
enum class Pulse { kFine, kLate, kHung };

/// Late after 20 ms without a cycle (logged), hung after 250 ms (killed and replaced; a host may
/// stall the machine for 90 ms), both plus the period of the loop.
Pulse judge_pulse(int64_t silent_ns, int64_t period_ns);

/// How long a process has been silent, minus the delays of its observer: a machine that slept has
/// not hung.
class Silence {
 public:
  /// One check of the heartbeat, made held_up_ns later than planned. Returns the time since beat_ns
  /// minus the delays of all checks that found this beat [ns].
  int64_t look(uint64_t beat, int64_t beat_ns, int64_t t_ns, int64_t held_up_ns);

 private:
  uint64_t beat_ = 0;
  int64_t held_up_ns_ = 0;  // sum over the checks of that beat
};

}  // namespace haptic

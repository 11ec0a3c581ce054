// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace haptic {

/// Pause before a process is started again after its n-th death in a row (n = 1, 2, …): none, 50
/// ms, 200 ms, then 1 s.
int64_t restart_delay_ns(int deaths_in_a_row);

/// A process that lived this long has recovered: its next death counts as the first.
inline constexpr int64_t kHealthyNs = 10'000'000'000;

/// A heartbeat that is late by this is worth a line in the log.
inline constexpr int64_t kLatePulseNs = 20'000'000;

/// What its heartbeat says about a running process.
enum class Pulse { kFine, kLate, kHung };

/// Late after 20 ms without a cycle (said), hung after 250 ms (killed and replaced; a host may hold
/// the machine up for 90 ms), both on top of the period of the loop.
Pulse judge_pulse(int64_t silent_ns, int64_t period_ns);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "clients/library/histogram.h"
#include "proto/os/realtime.h"

/// How late a loop on the deadline clock wakes, and whether that was the machine's doing.
namespace haptic {

struct LateWake {
  int64_t deadline_ns;
  int64_t late_ns;
};

// a wake this late must be explained: another loop on the same core was late too
inline constexpr int64_t kMustBeSharedNs = 200'000;
// the witness wakes 30 µs later, so of the same hole it sees less
inline constexpr int64_t kWitnessLateNs = 100'000;
inline constexpr int64_t kWitnessPhaseNs = 30'000;

struct WakeRun {
  Histogram late;
  uint64_t skipped = 0;
  uint64_t over_100us = 0;
  uint64_t over_1ms = 0;
  std::vector<LateWake> late_wakes;  // later than kWitnessLateNs, the first 65,536
  int64_t start_ns = 0;              // grid point 0
  RealtimeReport rights;
  int pin_errno = 0;
};

struct WakeOptions {
  double seconds = 15;
  int64_t period = 1'000'000;
  int64_t spin_ns = 0;  // kHybridSpinNs: hybrid
  int core = 0;
};

/// The servo's clock at the servo's priority, kept on the core, in a thread of its own.
WakeRun measure_wakes(const WakeOptions& options);

/// The witness alone, beside somebody else's loop: one priority lower, on the same core.
WakeRun measure_witness(const WakeOptions& options);

/// The same beside a witness: a second loop on the same core, one priority lower, 30 µs later.
struct WitnessedRun {
  WakeRun servo, witness;
};
WitnessedRun measure_witnessed_wakes(const WakeOptions& options);

/// Wakes later than kMustBeSharedNs.
struct SharedLateness {
  uint64_t late = 0;
  uint64_t shared = 0;             // the witness was held up at the same time
  int64_t largest_private_ns = 0;  // of those it did not share
};
SharedLateness compare_with_witness(const std::vector<LateWake>& servo,
                                    const std::vector<LateWake>& witness);

}  // namespace haptic

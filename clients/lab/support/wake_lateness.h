// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "clients/lab/support/cyclictest.h"
#include "proto/os/realtime.h"

/// Measures how late a loop on the deadline clock wakes, and finds out if the machine caused it.
namespace haptic {

struct LateWake {
  int64_t deadline_ns;
  int64_t late_ns;
};

// [ns]; a wake this late should coincide with a late wake of another loop on the same core
inline constexpr int64_t kMustBeSharedNs = 200'000;
// [ns]; the witness wakes 30 µs later and so sees less of the same delay
inline constexpr int64_t kWitnessLateNs = 100'000;
inline constexpr int64_t kWitnessPhaseNs = 30'000;  // [ns]

struct WakeRun : Lateness {
  uint64_t skipped = 0;
  std::vector<LateWake> late_wakes;  // later than kWitnessLateNs; the first 65,536
  int64_t start_ns = 0;              // grid point 0
  RealtimeReport rights;
  int pin_errno = 0;
};

struct WakeOptions {
  double seconds = 15;
  int64_t period = 1'000'000;
  int64_t spin_ns = 0;  // kHybridSpinNs selects the hybrid clock
  int core = 0;
};

/// Runs the servo's clock at the servo's priority, pinned to the core, in its own thread.
WakeRun measure_wakes(const WakeOptions& options);

/// Runs the witness alone, next to another program's loop: one priority lower, on the same core.
WakeRun measure_witness(const WakeOptions& options);

/// Runs the servo's loop with a witness: a loop one priority lower on the core, 30 µs later.
struct WitnessedRun {
  WakeRun servo, witness;
};
WitnessedRun measure_witnessed_wakes(const WakeOptions& options);

/// Wakes later than kMustBeSharedNs, compared with those of the witness.
struct SharedLateness {
  uint64_t late = 0;
  uint64_t shared = 0;             // the witness was delayed at the same time
  int64_t largest_private_ns = 0;  // largest lateness that was not shared
};
SharedLateness compare_with_witness(const std::vector<LateWake>& servo,
                                    const std::vector<LateWake>& witness);

}  // namespace haptic

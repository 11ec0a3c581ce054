// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/wake_lateness.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include "clients/lab/support/forked_process.h"
#include "proto/math/units.h"
#include "proto/os/priorities.h"

namespace haptic {
namespace {

constexpr size_t kMaxLateWakes = 65'536;    // capacity of late_wakes
constexpr int64_t kLeadTimeNs = 5'000'000;  // from ready to the first tick
constexpr int64_t kLookNs = 100'000;        // polling period until both are ready

/// Starts both loops when both are ready: until it is real-time, a thread may wait long for a core.
struct CommonStart {
  explicit CommonStart(int threads) : missing(threads) {}
  std::atomic<int> missing;
  std::atomic<int64_t> start_ns{0};

  int64_t wait() {
    --missing;
    // asleep, so that the thread of lower priority gets the shared core
    while (missing > 0) sleep_until(now_ns() + kLookNs);
    int64_t unset = 0;
    start_ns.compare_exchange_strong(unset, now_ns() + kLeadTimeNs);
    return start_ns;
  }
};

WakeRun run_loop(const WakeOptions& options, int priority, int64_t phase_ns, CommonStart& start) {
  WakeRun run;
  run.late_wakes.reserve(kMaxLateWakes);
  run.rights = enter_realtime({.fifo_priority = priority, .lock_memory = true});
  // real-time first: a pinned normal thread would wait long on a busy core
  run.pin_errno = pin_to(static_cast<size_t>(options.core));

  const int64_t start_ns = start.wait() + phase_ns;
  DeadlineClock clock(options.period, options.spin_ns);
  clock.start_at(start_ns);
  run.start_ns = start_ns;
  const int64_t end_ns = start_ns + static_cast<int64_t>(options.seconds * 1e9);
  for (Tick tick = clock.wait(); tick.deadline_ns < end_ns; tick = clock.wait()) {
    run.late.add(tick.late_ns);
    run.skipped = tick.skipped;
    if (tick.late_ns <= kWitnessLateNs) continue;
    ++run.over_100us;
    if (tick.late_ns > kMs) ++run.over_1ms;
    if (run.late_wakes.size() < kMaxLateWakes) {
      run.late_wakes.push_back({tick.deadline_ns, tick.late_ns});
    }
  }
  return run;
}

/// Runs in its own thread, so that real-time rights and pinning end with it.
WakeRun run_alone(const WakeOptions& options, int priority) {
  WakeRun run;
  CommonStart start(1);
  std::thread([&] { run = run_loop(options, priority, 0, start); }).join();
  return run;
}

}  // namespace

WakeRun measure_wakes(const WakeOptions& options) {
  return run_alone(options, kServoPriority);
}

WakeRun measure_witness(const WakeOptions& options) {
  return run_alone(options, kServoPriority - 1);
}

WitnessedRun measure_witnessed_wakes(const WakeOptions& options) {
  WitnessedRun run;
  CommonStart start(2);
  std::thread servo([&] { run.servo = run_loop(options, kServoPriority, 0, start); });
  std::thread witness(
      [&] { run.witness = run_loop(options, kServoPriority - 1, kWitnessPhaseNs, start); });
  servo.join();
  witness.join();
  return run;
}

SharedLateness compare_with_witness(const std::vector<LateWake>& servo,
                                    const std::vector<LateWake>& witness) {
  SharedLateness result;
  for (const LateWake& s : servo) {
    if (s.late_ns <= kMustBeSharedNs) continue;
    ++result.late;
    // delayed at the same time: the intervals from deadline to wake overlap
    const bool shared = std::any_of(witness.begin(), witness.end(), [&](const LateWake& w) {
      return w.late_ns > kWitnessLateNs && w.deadline_ns < s.deadline_ns + s.late_ns &&
             s.deadline_ns < w.deadline_ns + w.late_ns;
    });
    if (shared) {
      ++result.shared;
    } else {
      result.largest_private_ns = std::max(result.largest_private_ns, s.late_ns);
    }
  }
  return result;
}

}  // namespace haptic

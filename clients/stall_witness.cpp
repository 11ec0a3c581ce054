// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/stall_witness.h"

#include <algorithm>

#include "proto/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = 1'000'000;
constexpr int64_t kLateNs = 2'000'000;

}  // namespace

StallWitness::StallWitness(bool realtime) : thread_([this, realtime] { run(realtime); }) {}

StallWitness::~StallWitness() {
  ending_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void StallWitness::run(bool realtime) {
  enter_realtime({.fifo_priority = realtime ? 1 : 0, .lock_memory = false});
  DeadlineClock clock(kPeriodNs);
  while (!ending_.load(std::memory_order_relaxed)) {
    const Tick tick = clock.wait();
    if (tick.late_ns <= kLateNs) continue;
    const std::lock_guard lock(mutex_);
    stalls_.push_back({tick.deadline_ns, tick.deadline_ns + tick.late_ns});
  }
}

std::vector<Stall> StallWitness::stalls(int64_t since_ns) const {
  const std::lock_guard lock(mutex_);
  const auto first = std::find_if(stalls_.begin(), stalls_.end(),
                                  [&](const Stall& s) { return s.end_ns > since_ns; });
  return {first, stalls_.end()};
}

}  // namespace haptic

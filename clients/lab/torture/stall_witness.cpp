// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/stall_witness.h"

#include "clients/lab/support/forked_process.h"
#include "proto/os/priorities.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = 1'000'000;  // wake-up period of a thread
constexpr int64_t kLateNs = 2'000'000;    // lateness that counts as a stall

}  // namespace

StallWitness::StallWitness(bool realtime) {
  for (size_t i = 0; i < allowed_processors().size(); ++i) {
    threads_.emplace_back([this, i, realtime] { run(i, realtime); });
  }
}

StallWitness::~StallWitness() {
  ending_.store(true, std::memory_order_relaxed);
  for (std::thread& thread : threads_) thread.join();
}

void StallWitness::run(size_t processor, bool realtime) {
  pin_to_processor(processor);
  enter_realtime({.fifo_priority = realtime ? kWitnessPriority : 0, .lock_memory = false});
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
  // several threads append in the order in which their stalls end
  return stalls_since(stalls_, since_ns);
}

}  // namespace haptic

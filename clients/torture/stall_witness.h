// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "clients/torture/force_judge.h"

namespace haptic {

/// A thread on each processor that wakes every millisecond, does nothing, and notes when it was
/// more than two milliseconds late: then that processor had no time for anybody of its priority.
class StallWitness {
 public:
  /// `realtime`: with the lowest real-time priority, below every process of a session, where the
  /// kernel grants it.
  explicit StallWitness(bool realtime);
  ~StallWitness();
  StallWitness(const StallWitness&) = delete;

  /// What has ended since, of any processor; in order of time, none overlapping.
  std::vector<Stall> stalls(int64_t since_ns) const;

 private:
  void run(size_t processor, bool realtime);

  mutable std::mutex mutex_;
  std::vector<Stall> stalls_;
  std::atomic<bool> ending_{false};
  std::vector<std::thread> threads_;
};

}  // namespace haptic

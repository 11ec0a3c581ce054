// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "clients/lab/torture/force_judge.h"

namespace haptic {

/// One thread per processor that wakes every millisecond and records when it was more than 2 ms
/// late: then that processor could run nothing of its priority.
class StallWitness {
 public:
  /// `realtime`: with the lowest real-time priority, below every process of a session, if granted.
  explicit StallWitness(bool realtime);
  ~StallWitness();
  StallWitness(const StallWitness&) = delete;

  /// Stalls of any processor that ended after since_ns, in order of time and without overlap.
  std::vector<Stall> stalls(int64_t since_ns) const;

 private:
  void run(size_t processor, bool realtime);

  mutable std::mutex mutex_;
  std::vector<Stall> stalls_;
  std::atomic<bool> ending_{false};
  std::vector<std::thread> threads_;
};

}  // namespace haptic

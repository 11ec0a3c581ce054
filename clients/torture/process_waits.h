// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <vector>

#include "clients/torture/force_judge.h"

namespace haptic {

/// How long a process has waited for a processor since it began, by the kernel's count [ns]; 0
/// where the kernel does not count and for a process that is not there.
int64_t time_waited(pid_t pid);

/// When a process had no time: it waited for a processor, by the kernel's count
/// (/proc/<pid>/schedstat), or was stopped. Its own sleep is none of that, nor is its work.
class ProcessWaits {
 public:
  explicit ProcessWaits(pid_t pid) : pid_(pid) {}

  /// To be called every few milliseconds; what is found lies at the end of the time since the call
  /// before. Nothing is found where the kernel does not count.
  void look(int64_t t_ns);

  /// What has ended since; in order of time, none overlapping.
  std::vector<Stall> stalls(int64_t since_ns) const;

 private:
  pid_t pid_;
  int64_t looked_ns_ = 0, waited_ns_ = 0;
  std::vector<Stall> stalls_;
};

}  // namespace haptic

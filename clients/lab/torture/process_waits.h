// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <vector>

#include "clients/lab/torture/force_judge.h"

namespace haptic {

/// Total time the first thread of a process has waited for a processor, by the kernel's count [ns];
/// 0 if the kernel does not count or the process does not exist.
int64_t time_waited(pid_t pid);

/// Intervals in which a process could not run: one of its threads waited for a processor, by the
/// kernel's count (/proc/<pid>/task/<tid>/schedstat), or it was stopped. Its own sleep and work do
/// not count.
class ProcessWaits {
 public:
  explicit ProcessWaits(pid_t pid) : pid_(pid) {}

  /// Call every few milliseconds. A wait is placed at the end of the interval since the previous
  /// call. Finds nothing if the kernel does not count.
  void look(int64_t t_ns);

  /// The stalls that ended after since_ns, in order of time and without overlap.
  std::vector<Stall> stalls(int64_t since_ns) const;

 private:
  pid_t pid_;
  int64_t looked_ns_ = 0, waited_ns_ = 0;
  std::vector<Stall> stalls_;
};

}  // namespace haptic

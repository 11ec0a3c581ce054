// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <ctime>

namespace haptic {

/// CPU time used by this thread so far [ns].
inline int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

/// CPU time that this thread spends on some work [ns].
int64_t cpu_ns_of(const auto& work) {
  const int64_t begin = thread_cpu_ns();
  work();
  return thread_cpu_ns() - begin;
}

/// CPU time that this thread spends on some work [s].
double cpu_seconds_of(const auto& work) {
  return 1e-9 * static_cast<double>(cpu_ns_of(work));
}

}  // namespace haptic

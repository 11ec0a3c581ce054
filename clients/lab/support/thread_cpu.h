// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <ctime>

namespace haptic {

/// Time that some work takes on a clock [ns].
int64_t ns_on(clockid_t clock, const auto& work) {
  timespec begin{}, end{};
  clock_gettime(clock, &begin);
  work();
  clock_gettime(clock, &end);
  return (end.tv_sec - begin.tv_sec) * 1'000'000'000 + end.tv_nsec - begin.tv_nsec;
}

/// CPU time that this thread spends on some work [ns].
int64_t cpu_ns_of(const auto& work) {
  return ns_on(CLOCK_THREAD_CPUTIME_ID, work);
}

/// CPU time that this thread spends on some work [s].
double cpu_seconds_of(const auto& work) {
  return 1e-9 * static_cast<double>(cpu_ns_of(work));
}

}  // namespace haptic

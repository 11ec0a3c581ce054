// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <ctime>

namespace haptic {

/// CPU time used so far by this thread, or by what another clock counts [ns].
inline int64_t cpu_ns(clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  timespec t{};
  clock_gettime(clock, &t);
  return t.tv_sec * 1'000'000'000 + t.tv_nsec;
}

/// CPU time that some work takes, by the same clock [ns].
int64_t cpu_ns_of(const auto& work, clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  const int64_t begin = cpu_ns(clock);
  work();
  return cpu_ns(clock) - begin;
}

/// CPU time that some work takes [s].
double cpu_seconds_of(const auto& work, clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  return 1e-9 * static_cast<double>(cpu_ns_of(work, clock));
}

}  // namespace haptic

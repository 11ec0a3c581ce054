// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdlib>

#include "proto/os/realtime.h"

namespace haptic::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr size_t kSlowdown = 20;
#else
inline constexpr size_t kSlowdown = 1;
#endif

/// Number of random trials, fewer if a sanitizer slows them down.
constexpr size_t trials(size_t n) {
  return n / kSlowdown > 0 ? n / kSlowdown : 1;
}

/// The environment's HAPTIC_TORTURE_SCALE, which lengthens tests beyond CI; 1 if unset.
inline double torture_scale() {
  const char* text = std::getenv("HAPTIC_TORTURE_SCALE");
  return text != nullptr ? std::strtod(text, nullptr) : 1;
}

/// Length of a sweep that can be run in full by command: `trials` times the torture scale.
inline size_t sweep(size_t n) {
  return static_cast<size_t>(static_cast<double>(trials(n)) * torture_scale());
}

inline constexpr int64_t kPatienceNs = 60 * kNsPerSecond;  // only a hang takes this long

/// Polls every millisecond until the condition holds; false after a minute.
template <typename Condition>
bool eventually(Condition holds) {
  const int64_t give_up = now_ns() + kPatienceNs;
  while (!holds()) {
    if (now_ns() > give_up) return false;
    sleep_until(now_ns() + 1'000'000);
  }
  return true;
}

}  // namespace haptic::test

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/os/realtime.h"

namespace haptic::test {

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

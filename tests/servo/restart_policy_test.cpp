// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/restart_policy.cpp.
#include "servo/restart_policy.h"

#include <catch2/catch.hpp>

using haptic::judge_pulse;
using haptic::Pulse;
using haptic::restart_delay_ns;

constexpr int64_t kMs = 1'000'000;

TEST_CASE("restart policy: at once, then ever more slowly, a second at most", "[servo]") {
  CHECK(restart_delay_ns(1) == 0);
  CHECK(restart_delay_ns(2) == 50 * kMs);
  CHECK(restart_delay_ns(3) == 200 * kMs);
  for (const int deaths : {4, 5, 1000}) CHECK(restart_delay_ns(deaths) == 1000 * kMs);
}

TEST_CASE("restart policy: a heart is late after 20 ms and has stopped after 250 ms", "[servo]") {
  const int64_t period = GENERATE(1 * kMs, kMs / 8, 8 * kMs);
  CHECK(judge_pulse(20 * kMs + period, period) == Pulse::kFine);
  CHECK(judge_pulse(20 * kMs + period + 1, period) == Pulse::kLate);
  // a host that holds the machine up for 90 ms kills nobody
  CHECK(judge_pulse(90 * kMs, period) == Pulse::kLate);
  CHECK(judge_pulse(250 * kMs + period, period) == Pulse::kLate);
  CHECK(judge_pulse(250 * kMs + period + 1, period) == Pulse::kHung);
}

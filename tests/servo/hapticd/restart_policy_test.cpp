// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/hapticd/restart_policy.cpp.
#include "servo/hapticd/restart_policy.h"

#include <catch2/catch.hpp>

#include "proto/math/units.h"

using haptic::judge_pulse;
using haptic::kMs;
using haptic::Pulse;
using haptic::restart_delay_ns;
using haptic::Silence;
using haptic::spare_delay_ns;

TEST_CASE("restart policy: at once, then ever more slowly, a second at most", "[servo]") {
  const int64_t lived = GENERATE(0 * kMs, 199 * kMs);
  CHECK(restart_delay_ns(1, lived) == 0);
  CHECK(restart_delay_ns(2, lived) == 50 * kMs);
  CHECK(restart_delay_ns(3, lived) == 200 * kMs);
  for (const int deaths : {4, 5, 1000}) CHECK(restart_delay_ns(deaths, lived) == 1000 * kMs);
}

TEST_CASE("restart policy: a spare waits a second, then twice as long each time, a minute at most",
          "[servo]") {
  const int64_t lived = GENERATE(0 * kMs, 5000 * kMs);
  CHECK(spare_delay_ns(1, lived) == 1000 * kMs);
  CHECK(spare_delay_ns(2, lived) == 2000 * kMs);
  CHECK(spare_delay_ns(4, lived) == 8000 * kMs);
  for (const int deaths : {7, 8, 1000}) CHECK(spare_delay_ns(deaths, lived) == 64'000 * kMs);
}

TEST_CASE("restart policy: what is killed at a steady rate lives four fifths of the time",
          "[servo]") {
  const int64_t period = GENERATE(300 * kMs, 1000 * kMs, 3000 * kMs);
  int64_t lived = period;
  for (int deaths = 1; deaths < 100; ++deaths) {
    lived = period - restart_delay_ns(deaths, lived);
    REQUIRE(lived >= 3 * period / 4);
  }
  CHECK(lived >= 79 * period / 100);
}

TEST_CASE("restart policy: a heart is late after 20 ms and has stopped after 250 ms", "[servo]") {
  const int64_t period = GENERATE(1 * kMs, kMs / 8, 8 * kMs);
  CHECK(judge_pulse(20 * kMs + period, period) == Pulse::kFine);
  CHECK(judge_pulse(20 * kMs + period + 1, period) == Pulse::kLate);
  // a host that stalls the machine for 90 ms must not cause a kill
  CHECK(judge_pulse(90 * kMs, period) == Pulse::kLate);
  CHECK(judge_pulse(250 * kMs + period, period) == Pulse::kLate);
  CHECK(judge_pulse(250 * kMs + period + 1, period) == Pulse::kHung);
}

TEST_CASE("restart policy: a machine that was asleep has not hung", "[servo]") {
  const int64_t nap = 3000 * kMs;
  Silence silence;
  CHECK(silence.look(7, 100 * kMs, 110 * kMs, 0) == 10 * kMs);
  // asleep between two looks, and the process has not run again at the second and the third
  CHECK(silence.look(7, 100 * kMs, 130 * kMs + nap, nap) == 30 * kMs);
  CHECK(silence.look(7, 100 * kMs, 150 * kMs + nap, 0) == 50 * kMs);
  // the tolerance for one beat does not extend to the next
  CHECK(silence.look(8, 160 * kMs + nap, 470 * kMs + nap, 0) == 310 * kMs);
  // it beat once more just before the stall
  CHECK(silence.look(9, 471 * kMs + nap, 490 * kMs + 2 * nap, nap) == 19 * kMs);
}

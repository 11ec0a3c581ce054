// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/step_budget.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace haptic;

TEST_CASE("step budget: the deadline over what a point takes", "[clients]") {
  CHECK(budget_for({}, 1e-3) == 0);
  const std::vector<TimedStep> idle{{1e-6, 0}, {2e-6, 0}};
  CHECK(budget_for(idle, 1e-3) == 0);
  // 10 ns a point, whatever their number, and steps that say nothing
  std::vector<TimedStep> steps{{1e-6, 0}};
  for (uint64_t n = 1; n <= 1000; ++n) steps.push_back({1e-8 * static_cast<double>(n), n});
  CHECK(std::abs(static_cast<int64_t>(budget_for(steps, 0.8e-3)) - 80000) <= 1);
  // one step in a thousand that was disturbed does not count, one in ten does
  steps.push_back({1, 1});
  CHECK(budget_for(steps, 0.8e-3) > 79000);
  for (int i = 0; i < 100; ++i) steps.push_back({2e-5, 1000});
  CHECK(std::abs(static_cast<int64_t>(budget_for(steps, 0.8e-3)) - 40000) <= 1);
  // faster than any clock tells
  const std::vector<TimedStep> free{{0, 5}};
  CHECK(budget_for(free, 1e-3) == 0xffffffff);
}

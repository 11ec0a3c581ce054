// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/step_budget.h"

#include <catch2/catch.hpp>

using namespace haptic;

TEST_CASE("step budget: the largest that ends within the deadline", "[clients]") {
  // 10 ns per point plus a constant 100 µs
  int asked = 0;
  const auto time_of = [&](uint32_t budget) {
    ++asked;
    return 1e-4 + 1e-8 * budget;
  };
  const uint32_t budget = budget_for(0.8e-3, 1'000'000, time_of);
  CHECK(budget <= 70'000);
  CHECK(budget >= 63'000);
  CHECK(asked < 12);
  // the whole budget, and none
  CHECK(budget_for(0.8e-3, 5000, time_of) == 5000);
  CHECK(budget_for(1e-4, 1'000'000, time_of) == 0);
  CHECK(budget_for(0.9e-4, 1, time_of) == 0);
  CHECK(budget_for(1, 0, time_of) == 0);
}

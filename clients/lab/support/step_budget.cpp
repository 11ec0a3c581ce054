// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/step_budget.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kWithin = 1.1;  // ratio of the bounds at which the bisection ends

}  // namespace

uint32_t budget_for(double deadline, uint32_t most,
                    const std::function<double(uint32_t)>& time_of) {
  if (time_of(most) <= deadline) return most;
  double holds = 0, fails = most;
  while (fails > 1 && fails > kWithin * holds) {
    // geometric mean: bisection on a logarithmic scale
    const double middle = std::floor(std::sqrt(std::max(holds, 1.0) * fails));
    if (middle <= holds || middle >= fails) break;
    (time_of(static_cast<uint32_t>(middle)) <= deadline ? holds : fails) = middle;
  }
  return static_cast<uint32_t>(holds);
}

}  // namespace haptic

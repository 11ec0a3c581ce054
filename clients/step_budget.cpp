// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/step_budget.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace haptic {

uint32_t budget_for(std::span<const TimedStep> steps, double deadline) {
  std::vector<double> costs;
  for (const TimedStep& step : steps) {
    if (step.tested > 0) costs.push_back(step.cpu / static_cast<double>(step.tested));
  }
  if (costs.empty()) return 0;
  const size_t at = (costs.size() - 1) * 99 / 100;
  std::nth_element(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(at), costs.end());
  const double most = std::numeric_limits<uint32_t>::max();
  return costs[at] * most > deadline ? static_cast<uint32_t>(deadline / costs[at])
                                     : std::numeric_limits<uint32_t>::max();
}

}  // namespace haptic

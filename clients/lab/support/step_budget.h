// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>

namespace haptic {

/// The largest budget, at most `most`, with which a step meets the deadline [s], found by bisection
/// to within a tenth (for small budgets one or two points). `time_of` measures the duration of a
/// step for a budget [s] and should increase with it. 0 if no budget meets the deadline.
uint32_t budget_for(double deadline, uint32_t most, const std::function<double(uint32_t)>& time_of);

}  // namespace haptic

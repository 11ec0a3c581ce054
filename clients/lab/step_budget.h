// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>

namespace haptic {

/// A budget, at most `most`, with which a step takes no longer than the deadline [s], by bisection;
/// one larger by a tenth took longer (of small ones, by one or two points). `time_of` measures what
/// a step takes with a budget [s], which is to grow with it. 0 where none holds.
uint32_t budget_for(double deadline, uint32_t most, const std::function<double(uint32_t)>& time_of);

}  // namespace haptic

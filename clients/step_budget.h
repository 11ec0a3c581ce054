// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

namespace haptic {

/// A contact step: what it took and what it looked up.
struct TimedStep {
  double cpu = 0;  // [s]
  uint64_t tested = 0;
};

/// Points that a step may look up so that it ends within the deadline [s]: deadline / c, c the 99th
/// percentile of the steps' time a point, all that is done with what was found included. Steps that
/// looked nothing up say nothing; 0 where none is left.
uint32_t budget_for(std::span<const TimedStep> steps, double deadline);

}  // namespace haptic

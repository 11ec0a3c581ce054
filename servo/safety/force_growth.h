// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"

namespace haptic {

/// The most a wrench may grow in one tick.
struct WrenchGrowth {
  double force = 0;   // [N]
  double torque = 0;  // [N·m]
};

/// Limits the growth of `wanted` from the wrench held over the last tick. Both are in the same
/// frame; returns whether anything was cut. The force may shrink at once; it may end at most
/// growth.force away from the segment between zero and the held force, so growth along, across and
/// against it is bounded. A force farther away is moved straight towards the nearest point of the
/// segment. The torque is scaled with its force, then limited in the same way. A wall at rest never
/// reaches the limit: it pushes with k·(P(x) − x), P the projection onto the free space; where that
/// is convex, a motion Δx of the hand changes the force by k·|Δx| at most.
bool limit_growth(const Wrench& held, const WrenchGrowth& growth, Wrench& wanted);

}  // namespace haptic

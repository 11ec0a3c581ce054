// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"

namespace haptic {

/// By how much a wrench may grow in one tick.
struct WrenchGrowth {
  double force = 0;   // [N]
  double torque = 0;  // [N·m]
};

/// Brings what is wanted within reach of what was held. Of the held force any part may remain, so
/// what is reachable is the segment from zero to the held force, and all that is no further from it
/// than growth.force: a force shrinks at once, and grows by no more than that along itself, across
/// and against. What is further is drawn straight towards the segment's nearest point; the torque,
/// which belongs to the force, shrinks with it, and is then brought within reach in the same way.
/// All of one frame; returns whether anything was cut. A wall at rest pushes with
/// k·(P(x) − x), P the projection onto what is free: where that is convex, a hand that moves by Δx
/// changes the force by k·|Δx| at most.
bool limit_growth(const Wrench& held, const WrenchGrowth& growth, Wrench& wanted);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"

namespace haptic {

/// The most a wrench may grow in one tick.
struct WrenchGrowth {
  double force = 0;   // [N]
  double torque = 0;  // [N·m]
};

/// A part of a wrench as a mixture of what was held and what is wanted.
struct Mixture {
  double held = 0, wanted = 1;  // shares

  Vec3 of(const Vec3& before, const Vec3& now) const { return held * before + wanted * now; }
};

struct SlewLimit {
  Mixture force, torque;
  bool cut = false;

  /// The limited wrench, or likewise any part of it.
  Wrench of(const Wrench& held, const Wrench& wanted) const {
    return {force.of(held.f, wanted.f), torque.of(held.t, wanted.t)};
  }
};

/// Limits the growth of `wanted` from the wrench held over the last tick, both in the same frame:
/// the limited wrench is of(held, wanted). The force may shrink at once; it may end at most
/// growth.force away from the segment between zero and the held force, so growth along, across and
/// against it is bounded. A force farther away is moved straight towards the nearest point of the
/// segment. The torque is scaled with its force, then limited in the same way. A wall at rest never
/// reaches the limit: it pushes with k·(P(x) − x), P the projection onto the free space; where that
/// is convex, a motion Δx of the hand changes the force by k·|Δx| at most.
SlewLimit limit_slew(const Wrench& held, const WrenchGrowth& growth, const Wrench& wanted);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/convex/hull_pair.h"

namespace haptic {

/// The contact of two convex hulls: their nearest points while apart, the smallest translation that
/// parts them while they overlap. Where A is the object's frame normal_A points to the tool.
struct ConvexContact : HullTouch {
  double gap = 0;     // normal_A · (point_b − point_a): the distance; overlapping: −depth [m]
  bool real = true;   // both features lie on the surface of their objects
  bool found = true;  // false: the pose is not finite, or a hull is empty
};

/// The gap of two hulls, b at X_AB in the frame of a, warm-started from the state of the pair's
/// last query; any state, also one of other hulls of at least one vertex, gives the right answer.
/// While apart the gap is the distance by closest_features(); overlapping it is
/// −penetration_depth(), which joins at 0: so Kim's predictive depth (Kim, Otaduy, Lin, Manocha
/// 2003), the negative distance of a pair that is about to touch, is continuous with the depth. No
/// allocation; bounded work.
ConvexContact convex_contact(const Hull& a, const Hull& b, const Pose& X_AB,
                             ConvexPairState& state);

}  // namespace haptic

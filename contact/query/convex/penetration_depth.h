// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/convex/gauss_overlay.h"

namespace haptic {

/// The smallest translation that parts two hulls that overlap.
/// point_a − point_b = depth · n, with n = normal_A.
struct PenetrationDepth : HullTouch {
  double depth = 0;    // b moved by depth · n just touches a [m]; negative: they are apart along n
  bool real = true;    // both features lie on the surface of the object
  bool exact = false;  // the depth is the smallest of all directions: the polytope was searched
  int n_steps = 0;     // marching steps: overlay vertices that were better than the ones before
  bool fell_back = false;  // the local minimum was suspect, so the polytope was searched
};

/// Penetration depth of hull b at X_AB in the frame of hull a: DEEP (Kim, Lin, Manocha 2002), a
/// walk down the vertices of the overlay of the Gauss maps, each a facet of A ⊕ (−B) with the
/// distance of its plane from the origin. It starts at the last features of the state, or at the
/// last separating normal; a new pair, and now and then any, also at the direction between the
/// centroids. From the local minimum it searches all vertices around from which a convex body may
/// still hide a better one within 0.8 rad (7/√vertices rad, if less). Where that takes too long, or
/// another start was better, or the pair has not overlapped before, the minimum is suspect and
/// expand_polytope() finds the exact one. The depth is that of a direction, so never below the
/// exact one. No allocation; bounded work.
PenetrationDepth penetration_depth(const HullPair& pair, ConvexPairState& state);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/convex/hull_pair.h"

namespace haptic {

/// The nearest points of two hulls that are apart, and the features that they lie in.
struct ClosestFeatures : HullTouch {
  bool overlap = false;   // they have a common point; only the features are stated then
  double distance = 0;    // [m]
  bool converged = true;  // false: the steps ran out; the points are on the hulls, but may not be
                          // the nearest
  int n_steps = 0;
};

/// Distance of two hulls, b at X_AB in the frame of a, by feature walking (Lin & Canny 1991; Ehmann
/// & Lin 2001): from the state's features on, always to the neighbouring feature into whose Voronoi
/// region the other hull's nearest point says to go. Each step shortens the way between two points
/// of the hulls, so it ends, cannot go round in a circle, and ends at the nearest points, because
/// both are convex. A point that is found behind the face it was nearest to, which is where Lin &
/// Canny's walk may stand still, is followed through the hull to the face where it leaves it; where
/// it does not leave, or an edge pierces a face, the hulls overlap. A walk that does not end in 200
/// steps begins once more at the supports that expand_polytope() finds. No allocation.
ClosestFeatures closest_features(const HullPair& pair, ConvexPairState& state);

}  // namespace haptic

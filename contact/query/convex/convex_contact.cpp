// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/convex_contact.h"

#include "contact/query/convex/closest_features.h"
#include "contact/query/convex/penetration_depth.h"

namespace haptic {
namespace {

ConvexContact of_depth(const PenetrationDepth& found) {
  return {found, -found.depth, found.real, true};
}

ConvexContact of_distance(const HullPair& pair, const ClosestFeatures& found) {
  const bool real = is_real(pair.a, found.feature_a) && is_real(pair.b, found.feature_b);
  return {found, found.distance, real, true};
}

}  // namespace

ConvexContact convex_contact(const Hull& a, const Hull& b, const Pose& X_AB,
                             ConvexPairState& state) {
  ConvexContact nothing;
  nothing.found = false;
  if (!is_finite(X_AB) || a.faces.empty() || b.faces.empty()) return nothing;
  const HullPair pair(a, b, X_AB);
  // what the last query answered comes first; an overlap that has ended shows in its own direction
  if (state.overlapping != 0) {
    const PenetrationDepth depth = penetration_depth(pair, state);
    if (depth.depth > 0) return of_depth(depth);
  }
  const ClosestFeatures near = closest_features(pair, state);
  if (!near.overlap) return of_distance(pair, near);
  return of_depth(penetration_depth(pair, state));
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/point/patch_tests.h"

#include "contact/query/point/patch_lanes.h"

namespace haptic {

HAPTIC_WIDE LaneSet patches_near(const PatchNode& node, const PatchProbe& probe, float limit,
                                 Facing facing) {
  Float8 distance_squared;
  return patches_near(node, probe, limit_squared(limit), facing, distance_squared);
}

HAPTIC_WIDE LaneSet triangles_near(const PatchLeaf& leaf, const PatchProbe& probe, float limit) {
  Float8 at_least, at_most;
  bound_triangles(leaf, probe, at_least, at_most);
  return lanes_near(leaf, at_least, limit);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/patch_probe.h"
#include "contact/query/simd/lane_set.h"
#include "contact/shape/tree/patch_tree.h"
#include "proto/math/assert.h"

namespace haptic {

/// Patches within `limit` that may contain a point searched for. Conservative: keeps too many,
/// never too few.
LaneSet patches_near(const PatchNode& node, const PatchProbe& probe, float limit, Facing facing);

/// Triangles of the leaf that may be within `limit`. Conservative.
LaneSet triangles_near(const PatchLeaf& leaf, const PatchProbe& probe, float limit);

/// Visits every leaf below the nodes of which `near(node)` keeps lanes, in unspecified order.
template <class Near, class Visit>
void for_each_near_leaf(const PatchTree& tree, Near&& near, Visit&& visit) {
  std::array<uint32_t, kMaxPatchDepth * kPatchLanes> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = 0;
  while (n_waiting > 0) {
    const uint32_t child = waiting[--n_waiting];
    if (child == kNoPatch) continue;
    if ((child & kPatchLeaf) != 0) {
      visit(tree.leaves[child & ~kPatchLeaf]);
      continue;
    }
    const PatchNode& node = tree.nodes[child];
    HAPTIC_ASSERT(n_waiting + kPatchLanes <= waiting.size());
    for (LaneSet lanes = near(node); lanes.any(); lanes.pop()) {
      waiting[n_waiting++] = node.child[lanes.first()];
    }
  }
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/simd/lane_set.h"
#include "contact/shape/tree/patch_tree.h"
#include "proto/math/assert.h"

namespace haptic {

/// Which points of a patch are searched: any; local minima of the distance; local minima seen from
/// the front.
enum class Facing { kAny, kEitherSide, kFront };

/// A point prepared for the tests, in float with conservative rounding.
struct PatchProbe {
  explicit PatchProbe(const Vec3& p) : p_O(p) {
    constexpr float kUlp = 1.2e-7F;  // an ulp of 1
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<size_t>(k);
      const auto x = static_cast<float>(p[k]);
      const float ulp = kUlp * (x < 0 ? -x : x);
      at[row] = x, below[row] = x - ulp, above[row] = x + ulp;
      slack += 4 * ulp;  // a rounding of p, one of the product, two of the sum
    }
  }

  Vec3 p_O;
  std::array<float, 3> below, above, at;
  float slack = 0;  // of axis·p
};

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

/// A float no less than the distance.
inline float round_up_distance(double distance) {
  constexpr float kUlp = 1.2e-7F;
  return static_cast<float>(distance) * (1 + kUlp) + 1e-18F;
}

/// Limit for squared distances of patches, rounded up.
inline float limit_squared(float limit) {
  constexpr float kSumError = 1e-5F;
  return limit * limit * (1 + kSumError);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/simd/lane_set.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {

/// Which points of a patch are asked for: any, those locally nearest to the point, or of these
/// those that have it in front.
enum class Facing { kAny, kEitherSide, kFront };

/// A point made ready for the tests, in float rounded the safe way.
struct PatchProbe {
  explicit PatchProbe(const Vec3& p) : p_O(p) {
    constexpr float kUlp = 1.2e-7F;  // a whole rounding
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

/// Patches no further than `limit` that may hold a point asked for. Keeps too many, never too few.
LaneSet patches_near(const PatchNode& node, const PatchProbe& probe, float limit, Facing facing);

/// Triangles of the leaf that may be no further than `limit`. Keeps too many, never too few.
LaneSet triangles_near(const PatchLeaf& leaf, const PatchProbe& probe, float limit);

/// Every leaf below the nodes of which `near(node)` keeps lanes, in no order that matters.
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
    for (LaneSet lanes = near(node); lanes.any(); lanes.pop()) {
      waiting[n_waiting++] = node.child[lanes.first()];
    }
  }
}

/// The float no less than a distance.
inline float round_up_distance(double distance) {
  constexpr float kUlp = 1.2e-7F;
  return static_cast<float>(distance) * (1 + kUlp) + 1e-18F;
}

/// What is to be compared with the squared distances of patches.
inline float limit_squared(float limit) {
  constexpr float kSumError = 1e-5F;
  return limit * limit * (1 + kSumError);
}

}  // namespace haptic

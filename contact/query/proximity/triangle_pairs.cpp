// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/triangle_pairs.h"

#include <array>
#include <limits>

#include "contact/query/box/obb_overlap.h"
#include "proto/math/assert.h"

namespace haptic {

size_t triangle_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                      std::span<TrianglePair> out) {
  constexpr size_t kAny = std::numeric_limits<size_t>::max();
  return triangle_pairs_within(shape_A, shape_B, X_AB, out, kAny).value_or(0);
}

std::optional<size_t> triangle_pairs_within(const MeshShape& shape_A, const MeshShape& shape_B,
                                            const Pose& X_AB, std::span<TrianglePair> out,
                                            size_t most_boxes) {
  const ObbTree &tree_A = shape_A.tree, &tree_B = shape_B.tree;
  if (tree_A.nodes.empty() || tree_B.nodes.empty() || !is_finite(X_AB)) return 0;
  size_t found = 0;
  const auto test_leaves = [&](const ObbNode& a, const ObbNode& b) {
    for (uint32_t j = 0; j < b.count; ++j) {
      const uint32_t triangle_b = tree_B.order[b.first + j];
      const Corners corners_b = corners_of(shape_B.mesh, triangle_b, X_AB);
      for (uint32_t i = 0; i < a.count; ++i) {
        const uint32_t triangle_a = tree_A.order[a.first + i];
        if (!triangles_meet(corners_of(shape_A.mesh, triangle_a), corners_b)) continue;
        if (found < out.size()) out[found] = {triangle_a, triangle_b};
        ++found;
      }
    }
    return true;
  };
  const ObbSweep sweep = at_rest(X_AB);
  size_t n_boxes = 0;
  // once the budget has ended, what still waits is passed over
  const auto may_meet = [&](const CompactObb& a, const CompactObb& b) {
    return n_boxes++ < most_boxes && boxes_may_meet(a, b, sweep);
  };
  descend_both(tree_A, tree_B, may_meet, test_leaves);
  return n_boxes <= most_boxes ? std::optional(found) : std::nullopt;
}

}  // namespace haptic

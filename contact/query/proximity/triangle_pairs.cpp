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
  };
  const ObbSweep sweep = at_rest(X_AB);
  std::array<NodePair, kMaxWaitingPairs> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = {0, 0};
  for (size_t n_boxes = 0; n_waiting > 0; ++n_boxes) {
    if (n_boxes == most_boxes) return {};
    const NodePair pair = waiting[--n_waiting];
    const ObbNode &a = tree_A.nodes[pair.a], &b = tree_B.nodes[pair.b];
    if (!boxes_may_meet(a.box, b.box, sweep)) continue;
    if (a.count > 0 && b.count > 0) {
      test_leaves(a, b);
      continue;
    }
    HAPTIC_ASSERT(n_waiting + 2 <= waiting.size());
    for (const NodePair& half : opened(pair, tree_A, tree_B)) waiting[n_waiting++] = half;
  }
  return found;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/query/box/box_distance.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

struct Branch {
  NodePair nodes;
  double at_least;
};

/// Measures what waits; only a pair nearer than result.at_least replaces the nearest.
void measure_into(PairBatch& batch, MeshDistance& result) {
  batch.measure_each([&](double distance_squared, const auto& near) {
    const double distance = std::sqrt(distance_squared);
    if (!(distance < result.at_least)) return true;
    result.found = true;
    result.nearest = near();
    result.at_least = distance;
    return true;
  });
}

}  // namespace

MeshDistance mesh_distance(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                           const DistanceSearch& search) {
  const ObbTree &tree_A = shape_A.tree, &tree_B = shape_B.tree;
  MeshDistance result;
  if (tree_A.nodes.empty() || tree_B.nodes.empty() || !is_finite(X_AB)) return result;
  HAPTIC_ASSERT(search.share > 0 && search.share <= 1);
  HAPTIC_ASSERT(search.limit >= 0);
  const BoxDistance boxes(X_AB);
  const auto apart = [&](const NodePair& pair) {
    return boxes.at_least(tree_A.nodes[pair.a].box, tree_B.nodes[pair.b].box);
  };
  result.at_least = search.limit;
  PairBatch batch(shape_A, shape_B, X_AB);
  if (search.witness != nullptr) {
    batch.add(*search.witness);
    measure_into(batch, result);
  }
  const auto is_too_near = [&] { return result.found && result.at_least < search.least; };
  // each level replaces one branch by two
  std::array<Branch, 2 * kMaxTreeDepth + 2> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = {{0, 0}, apart({0, 0})};
  while (n_waiting > 0 && result.n_boxes < search.most_boxes && !is_too_near()) {
    const Branch branch = waiting[--n_waiting];
    if (!(branch.at_least < search.share * result.at_least)) continue;
    const ObbNode &a = tree_A.nodes[branch.nodes.a], &b = tree_B.nodes[branch.nodes.b];
    if (a.count > 0 && b.count > 0) {
      batch.add_leaves(a, b);
      measure_into(batch, result);
      continue;
    }
    std::array<NodePair, 2> halves = opened(branch.nodes, tree_A, tree_B);
    Branch first{halves[0], apart(halves[0])}, second{halves[1], apart(halves[1])};
    if (first.at_least < second.at_least) std::swap(first, second);
    result.n_boxes += 2;
    HAPTIC_ASSERT(n_waiting + 2 <= waiting.size());
    waiting[n_waiting++] = first;
    waiting[n_waiting++] = second;
  }
  if (is_too_near()) {
    result.at_least = 0;
    return result;
  }
  result.at_least *= search.share;
  while (n_waiting > 0) result.at_least = std::min(result.at_least, waiting[--n_waiting].at_least);
  return result;
}

}  // namespace haptic

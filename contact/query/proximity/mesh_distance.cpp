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

/// Pairs of triangles that are measured together; keeps the nearest in a result.
class PairBatch {
 public:
  PairBatch(const TriangleMesh& mesh_A, const TriangleMesh& mesh_B, const Pose& X_AB)
      : mesh_A_(mesh_A), mesh_B_(mesh_B), X_AB_(X_AB) {}

  void add(const TrianglePair& pair) {
    HAPTIC_ASSERT(pair.a < mesh_A_.triangles.size() && pair.b < mesh_B_.triangles.size());
    pairs_[batch_.n] = pair;
    batch_.add(corners_of(mesh_A_, pair.a), corners_of(mesh_B_, pair.b));
  }

  /// Every pair of a triangle of one leaf and one of the other.
  void add_leaves(const ObbTree& tree_A, const ObbNode& a, const ObbTree& tree_B,
                  const ObbNode& b) {
    for (uint32_t j = 0; j < b.count; ++j) {
      for (uint32_t i = 0; i < a.count; ++i) {
        add({tree_A.order[a.first + i], tree_B.order[b.first + j]});
      }
    }
  }

  /// Measures what was added; only a pair nearer than result.at_least replaces the nearest.
  void measure_into(MeshDistance& result) {
    measure(X_AB_, batch_);
    for (size_t i = 0; i < batch_.n; ++i) {
      const double distance = std::sqrt(batch_.distance_squared[i]);
      if (!(distance < result.at_least)) continue;
      result.found = true;
      result.nearest = {pairs_[i], measured(batch_, i)};
      result.at_least = distance;
    }
    batch_.n = 0;
  }

 private:
  const TriangleMesh& mesh_A_;
  const TriangleMesh& mesh_B_;
  const Pose& X_AB_;
  DistanceBatch batch_;
  std::array<TrianglePair, DistanceBatch::kRoom> pairs_;
};

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
  PairBatch batch(shape_A.mesh, shape_B.mesh, X_AB);
  if (search.witness != nullptr) {
    batch.add(*search.witness);
    batch.measure_into(result);
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
      batch.add_leaves(tree_A, a, tree_B, b);
      batch.measure_into(result);
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

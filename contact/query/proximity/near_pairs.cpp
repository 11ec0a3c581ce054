// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/near_pairs.h"

#include <cmath>

#include "contact/query/box/box_distance.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Pairs of triangles whose distances are to be measured together.
struct WaitingPair {
  DistanceBatch batch;
  std::array<TrianglePair, DistanceBatch::kRoom> pairs;
};

/// Calls on_near for each near pair until it returns false.
template <class OnNear>
bool measure_waiting(WaitingPair& waiting, const Pose& X_AB, double band, OnNear&& on_near) {
  DistanceBatch& batch = waiting.batch;
  measure(X_AB, batch);
  for (size_t i = 0; i < batch.n; ++i) {
    if (batch.distance_squared[i] > band * band) continue;
    if (!on_near(waiting.pairs[i], batch, i)) return false;
  }
  batch.n = 0;
  return true;
}

/// False if on_near ended the descent.
template <class OnNear>
bool descend(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB, double band,
             OnNear&& on_near) {
  const ObbTree &tree_A = shape_A.tree, &tree_B = shape_B.tree;
  const bool is_band = std::isfinite(band) && band >= 0;
  if (tree_A.nodes.empty() || tree_B.nodes.empty() || !is_finite(X_AB) || !is_band) return true;
  const BoxDistance boxes(X_AB);
  WaitingPair found;
  const auto wait = [&](const ObbNode& a, const ObbNode& b) {
    HAPTIC_ASSERT(found.batch.n + size_t{a.count} * b.count <= DistanceBatch::kRoom);
    for (uint32_t j = 0; j < b.count; ++j) {
      const uint32_t triangle_b = tree_B.order[b.first + j];
      for (uint32_t i = 0; i < a.count; ++i) {
        const uint32_t triangle_a = tree_A.order[a.first + i];
        found.pairs[found.batch.n] = {triangle_a, triangle_b};
        found.batch.add(corners_of(shape_A.mesh, triangle_a), corners_of(shape_B.mesh, triangle_b));
      }
    }
  };
  std::array<NodePair, kMaxWaitingPairs> waiting;
  size_t n_waiting = 0;
  waiting[n_waiting++] = {0, 0};
  while (n_waiting > 0) {
    const NodePair pair = waiting[--n_waiting];
    const ObbNode &a = tree_A.nodes[pair.a], &b = tree_B.nodes[pair.b];
    if (boxes.at_least(a.box, b.box) > band) continue;
    if (a.count > 0 && b.count > 0) {
      wait(a, b);
      const bool has_room = found.batch.n + kLeafTriangles * kLeafTriangles <= DistanceBatch::kRoom;
      if (!has_room && !measure_waiting(found, X_AB, band, on_near)) return false;
      continue;
    }
    HAPTIC_ASSERT(n_waiting + 2 <= waiting.size());
    for (const NodePair& half : opened(pair, tree_A, tree_B)) waiting[n_waiting++] = half;
  }
  return measure_waiting(found, X_AB, band, on_near);
}

}  // namespace

size_t near_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB, double band,
                  std::span<NearPair> out) {
  size_t found = 0;
  descend(shape_A, shape_B, X_AB, band,
          [&](const TrianglePair& pair, const DistanceBatch& batch, size_t i) {
            if (found < out.size()) out[found] = {pair, measured(batch, i)};
            ++found;
            return true;
          });
  return found;
}

bool any_near_pair(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                   double band) {
  return !descend(shape_A, shape_B, X_AB, band,
                  [](const TrianglePair&, const DistanceBatch&, size_t) { return false; });
}

}  // namespace haptic

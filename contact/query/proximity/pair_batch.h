// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "contact/query/proximity/triangle_pairs.h"
#include "contact/query/triangle/distance_batch.h"
#include "contact/query/triangle/triangle_distance.h"

namespace haptic {

/// A triangle of A and one of B that are near, and their closest points, in A.
struct NearPair {
  TrianglePair triangles;
  TriangleDistance at;
};

/// Pairs of triangles of two meshes that are measured together, with B at X_AB in A.
class PairBatch {
 public:
  /// All three must outlive it.
  PairBatch(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB)
      : shape_A_(shape_A), shape_B_(shape_B), X_AB_(X_AB) {}
  /// There must be room.
  void add(const TrianglePair& pair);
  /// Adds every pair of a triangle of one leaf and one of the other.
  void add_leaves(const ObbNode& a, const ObbNode& b);
  bool has_room_for_leaves() const {
    return batch_.n + kLeafTriangles * kLeafTriangles <= DistanceBatch::kRoom;
  }

  /// Measures the pairs and empties the batch. Calls f(distance squared, near), where near() is the
  /// NearPair, for each until f returns false; false: it did.
  template <class F>
  bool measure_each(const F& f) {
    measure(X_AB_, batch_);
    for (size_t i = 0; i < batch_.n; ++i) {
      const auto near = [&] { return NearPair{pairs_[i], measured(batch_, i)}; };
      if (!f(batch_.distance_squared[i], near)) return false;
    }
    batch_.n = 0;
    return true;
  }

 private:
  const MeshShape &shape_A_, &shape_B_;
  const Pose& X_AB_;
  DistanceBatch batch_;
  std::array<TrianglePair, DistanceBatch::kRoom> pairs_;
};

inline void PairBatch::add(const TrianglePair& pair) {
  pairs_[batch_.n] = pair;
  batch_.add(corners_of(shape_A_.mesh, pair.a), corners_of(shape_B_.mesh, pair.b));
}

inline void PairBatch::add_leaves(const ObbNode& a, const ObbNode& b) {
  for (uint32_t j = 0; j < b.count; ++j) {
    for (uint32_t i = 0; i < a.count; ++i) {
      add({shape_A_.tree.order[a.first + i], shape_B_.tree.order[b.first + j]});
    }
  }
}

}  // namespace haptic

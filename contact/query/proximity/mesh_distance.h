// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <limits>

#include "contact/query/proximity/near_pairs.h"

namespace haptic {

/// The nearest two triangles of two meshes.
struct MeshDistance {
  bool found = false;
  NearPair nearest;     // in A
  double at_least = 0;  // lower bound of the distance [m]: the distance itself, the limit, or less
  size_t n_boxes = 0;   // box tests
};

/// Conditions for ending a search for the distance of two meshes early.
struct DistanceSearch {
  double limit = std::numeric_limits<double>::infinity();  // pairs farther apart are not found [m]
  const TrianglePair* witness = nullptr;  // a pair that was near before: tested first (warm start)
  double share = 1;  // prunes boxes that are no nearer than this share of the best distance
  double least = 0;  // stops at the first pair nearer than this; at_least is then 0 [m]
  size_t most_boxes = std::numeric_limits<size_t>::max();  // budget of box tests
};

/// Distance of the surfaces of two meshes with B at X_AB in A, 0 where they meet: branch and bound
/// over both trees, the nearer half first. Nothing is found if the distance exceeds the limit. With
/// a share below 1, or when the budget ends, the pair found may not be the nearest; at_least is a
/// lower bound in any case. Nothing for a pose that is not finite.
MeshDistance mesh_distance(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                           const DistanceSearch& search);

inline MeshDistance mesh_distance(const MeshShape& shape_A, const MeshShape& shape_B,
                                  const Pose& X_AB,
                                  double limit = std::numeric_limits<double>::infinity(),
                                  const TrianglePair* witness = nullptr) {
  return mesh_distance(shape_A, shape_B, X_AB, DistanceSearch{limit, witness});
}

}  // namespace haptic

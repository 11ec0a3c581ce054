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
  double at_least = 0;  // no two points are nearer [m]; the distance itself, the limit, or a bound
  size_t n_boxes = 0;   // pairs of them that were compared
};

/// Where a search for the distance of two meshes may end early.
struct DistanceSearch {
  double limit = std::numeric_limits<double>::infinity();  // what is further is not found [m]
  const TrianglePair* witness = nullptr;  // a pair that was near before, asked first
  double share = 1;  // what is no nearer than this share of what was found is not looked at
  double least = 0;  // once something nearer is found nothing more is, and at_least is 0 [m]
  size_t most_boxes = std::numeric_limits<size_t>::max();  // pairs of them that are compared
};

/// Distance of the surfaces of two meshes with B at X_AB in A, 0 where they meet, by branch and
/// bound over both trees, the nearer half first. Once it knows that the distance is beyond the
/// limit nothing is found. With a share below 1, or where the boxes come to an end, the nearest
/// that was found may not be the nearest, and at_least is a lower bound, of the limit too. Nothing
/// for a pose that is not finite.
MeshDistance mesh_distance(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                           const DistanceSearch& search);

inline MeshDistance mesh_distance(const MeshShape& shape_A, const MeshShape& shape_B,
                                  const Pose& X_AB,
                                  double limit = std::numeric_limits<double>::infinity(),
                                  const TrianglePair* witness = nullptr) {
  return mesh_distance(shape_A, shape_B, X_AB, DistanceSearch{limit, witness});
}

}  // namespace haptic

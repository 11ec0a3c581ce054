// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

#include "contact/query/near_pairs.h"

namespace haptic {

/// The nearest two triangles of two meshes.
struct MeshDistance {
  bool found = false;
  NearPair nearest;     // in A
  double at_least = 0;  // no two points are nearer [m]; the distance itself, or the limit
};

/// Distance of the surfaces of two meshes with B at X_AB in A, 0 where they meet, by branch and
/// bound over both trees, the nearer half first. Ends early once it knows that the distance is
/// beyond `limit` [m]: then nothing is found. `witness`, a pair that was near before, is asked
/// first. Nothing for a pose that is not finite.
MeshDistance mesh_distance(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                           double limit = std::numeric_limits<double>::infinity(),
                           const TrianglePair* witness = nullptr);

}  // namespace haptic

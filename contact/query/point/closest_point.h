// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include <span>
#include "contact/query/triangle/closest_on_triangle.h"

#include "contact/shape/baked/mesh_shape.h"
#include "proto/math/pose.h"

namespace haptic {

inline constexpr size_t kFrontNodes = 12;

/// What the last queries of one moving point tell of the next: the caller keeps one for each point
/// and object. It holds the nodes of the patch tree below which lies all that is near, and from how
/// near nothing else can be; while the point stays within that, the rest of the tree is not looked
/// at. It never changes a result, be it stale or of another mesh; a mesh rebuilt in place of
/// another wants a new one.
class ClosestWitness {
 private:
  friend class WitnessedSearch;

  const PatchNode* tree_ = nullptr;  // what it is about
  Vec3 p_O_, point_O_;               // the last query that found something, and what it found
  double triangle_size_ = 0;         // there [m]
  Vec3 centre_O_;                    // what is no further from here than `clearance_` …
  double clearance_ = 0;             // [m]
  size_t n_nodes_ = 0;
  std::array<uint32_t, kFrontNodes> nodes_{};  // … lies below these
};

/// Closest point of the mesh to p_O within max_distance, with the feature it lies on and the side
/// by pseudo-normals (Bærentzen & Aanæs 2005; false for open meshes). Descent of the patch tree,
/// nearest first; patches that do not face the point are left out: the nearest point is a locally
/// nearest one. Exact in double; ties go to the lower triangle index.
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance);
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance,
                           ClosestWitness& witness);

/// Whether any of these points lies in a mesh that is closed: with one of each shell of another
/// mesh (points_of_shells), where their surfaces do not meet, whether it holds any of that one.
bool holds(const MeshShape& outer, std::span<const Vec3> points, const Pose& X_outer_inner);

}  // namespace haptic

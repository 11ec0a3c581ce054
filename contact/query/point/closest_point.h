// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include <span>
#include "contact/query/triangle/closest_on_triangle.h"

#include "contact/shape/baked/mesh_shape.h"
#include "proto/math/pose.h"

namespace haptic {

inline constexpr size_t kFrontNodes = 12;  // of a witness, at most

/// Warm start for the queries of one moving point: the caller keeps one per point and object. It
/// holds a front of the patch tree that contains everything within some distance of a centre; while
/// the query stays inside that distance, only the front is searched. It never changes a result,
/// even if stale or of another mesh; but if a mesh is replaced in place, a new witness is needed.
class ClosestWitness {
 private:
  friend class WitnessedSearch;

  const PatchNode* tree_ = nullptr;  // identifies the tree
  Vec3 p_O_, point_O_;               // last query that found something, and the point found
  double triangle_size_ = 0;         // size of the triangle found [m]
  Vec3 centre_O_;                    // everything within `clearance_` of this …
  double clearance_ = 0;             // [m]
  size_t n_nodes_ = 0;
  std::array<uint32_t, kFrontNodes> nodes_{};  // … lies below these nodes
};

/// Closest point of the mesh to p_O within max_distance [m], with the feature it lies on and the
/// side by pseudo-normals (Bærentzen & Aanæs 2005; false for open meshes). Traverses the patch tree
/// nearest first; patches that do not face the point are pruned, since the nearest point is a local
/// minimum. Exact in double; ties go to the lower triangle index.
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance);
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance,
                           ClosestWitness& witness);

/// Whether any of these points lies inside a closed mesh. With one point of each shell of another
/// mesh (points_of_shells), and if the surfaces do not meet: whether it contains any part of that
/// mesh.
bool holds(const MeshShape& outer, std::span<const Vec3> points, const Pose& X_outer_inner);

}  // namespace haptic

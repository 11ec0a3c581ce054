// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/closest_on_triangle.h"
#include "contact/shape/mesh_shape.h"

namespace haptic {

/// Where the last query of one point ended: the caller keeps one for each moving point and object.
/// Where the point moved little, the search begins there, at patches nearby, and knows at once how
/// far it need look. It never changes a result, be it stale, of another object or out of range.
struct ClosestWitness {
  Vec3 p_O, point_O;
  double reach = 0;  // how far a move still counts as little [m]
  uint32_t node = 0;
};

/// Closest point of the mesh to p_O within max_distance, with the feature it lies on and the side
/// by pseudo-normals (Bærentzen & Aanæs 2005; false for open meshes). Descent of the patch tree,
/// nearest first; patches that do not face the point are left out: the nearest point is a locally
/// nearest one. Exact in double; ties go to the lower triangle index.
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance);
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance,
                           ClosestWitness& witness);

}  // namespace haptic

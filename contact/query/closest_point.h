// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/shape/obb_tree.h"

namespace haptic {

enum class FeatureKind : uint32_t { kFace = 0, kEdge = 1, kVertex = 2 };

/// What the closest point lies on; `index` counts faces, edges or vertices of the mesh.
struct Feature {
  FeatureKind kind = FeatureKind::kFace;
  uint32_t index = 0;
  bool operator==(const Feature&) const = default;
  /// Stable id for the wire: kind in the top two bits.
  uint64_t id() const { return (static_cast<uint64_t>(kind) << 62) | index; }
};

/// Angle-weighted normal of a feature: which side of the surface is outside (Bærentzen & Aanæs
/// 2005).
const Vec3& pseudo_normal(const TriangleMesh& mesh, const Feature& feature);

struct ClosestPoint {
  bool found = false;
  double distance = 0;  // unsigned [m]
  Vec3 point_O;
  Feature feature;
  uint32_t triangle = 0;
  bool inside = false;  // behind the pseudo-normal of the feature (closed meshes)
};

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

/// Closest point of one triangle, with its feature (Ericson 2005, §5.1.5).
ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const Vec3& p_O);

/// Every triangle with a point nearer than radius, as its closest point, unordered. Writes at most
/// out.size() and returns how many there were (more than out.size(): truncated).
size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

/// Those of triangles_within that can touch a point of the surface locally nearest to p_O and seen
/// from the front, and some others: all of them around each such point. How many there are depends
/// on the shape of the surface, hardly on how finely it is meshed.
size_t triangles_facing(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

}  // namespace haptic

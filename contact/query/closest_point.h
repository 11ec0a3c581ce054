// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/shape/mesh_shape.h"

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

/// Closest point of the mesh to p_O within max_distance, with the feature it lies on and the side
/// by pseudo-normals (Bærentzen & Aanæs 2005; false for open meshes). Depth-first descent of the
/// OBB tree, nearer child first; exact in double; ties go to the lower triangle index.
ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance);

/// Closest point of one triangle, with its feature (Ericson 2005, §5.1.5).
ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const Vec3& p_O);

/// Every triangle with a point nearer than radius, as its closest point, unordered. Writes at most
/// out.size() and returns how many there were (more than out.size(): truncated).
size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

// nearer than this, the direction to the point is rounding noise [m]
inline constexpr double kOnSurface = 1e-12;

enum class FeatureKind : uint32_t { kFace = 0, kEdge = 1, kVertex = 2 };

/// The feature that a closest point lies on; `index` counts faces, edges or vertices of the mesh.
struct Feature {
  FeatureKind kind = FeatureKind::kFace;
  uint32_t index = 0;
  bool operator==(const Feature&) const = default;
  /// Stable id for the wire: kind in the top two bits.
  uint64_t id() const { return (static_cast<uint64_t>(kind) << 62) | index; }
};

/// Angle-weighted normal of a feature; it tells inside from outside (Bærentzen & Aanæs 2005).
const Vec3& pseudo_normal(const TriangleMesh& mesh, const Feature& feature);

struct ClosestPoint {
  bool found = false;
  double distance = 0;  // unsigned [m]
  Vec3 point_O;
  Feature feature;
  uint32_t triangle = 0;
  bool inside = false;  // behind the pseudo-normal of the feature (closed meshes only)
};

/// Place on a triangle: corner or side `index`, numbered as in TriangleMesh, or the face.
struct OnTriangle {
  Vec3 point;
  FeatureKind kind;
  uint32_t index = 0;
};

/// Closest point of one triangle by the Voronoi regions of its corners, sides and face (Ericson
/// 2005, §5.1.5); for a triangle without area, of its sides.
OnTriangle closest_on_triangle(const TriangleMesh& mesh, uint32_t triangle, const Vec3& p_O);

/// The corner, side or face as a feature of the mesh.
Feature feature_of(const TriangleMesh& mesh, uint32_t triangle, const OnTriangle& on);

/// The full result: feature, distance and side of the surface.
ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const OnTriangle& on, const Vec3& p_O);
ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const Vec3& p_O);

}  // namespace haptic

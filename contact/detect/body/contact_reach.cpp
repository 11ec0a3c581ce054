// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/contact_reach.h"

#include <algorithm>

#include "contact/query/point/closest_point.h"
#include "contact/query/triangle/plane_extent.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kCorner = 0.1 * kMinExtent;  // a surface that ends sooner is a corner [m]

/// Direction of an edge, and the distance to its nearer end.
struct EdgeAt {
  Vec3 along;
  double length = 0;
};

EdgeAt edge_at(const ContactSide& side) {
  const Triangle& edges = side.mesh.triangle_edges[side.triangle];
  for (size_t i = 0; i < 3; ++i) {
    if (edges[i] != side.feature.index) continue;
    const Triangle& corners = side.mesh.triangles[side.triangle];
    const Vec3 &p = side.mesh.vertices[corners[i]], &q = side.mesh.vertices[corners[(i + 1) % 3]];
    return {normalized(q - p), std::min(norm(side.point - p), norm(side.point - q))};
  }
  return {};
}

/// How far two edges cross, whatever the direction; 0 where one of the features is none.
double crossing_extent(const ContactSide& object, const ContactSide& tool, const Pose& X_OT) {
  if (object.feature.kind != FeatureKind::kEdge || tool.feature.kind != FeatureKind::kEdge)
    return 0;
  const EdgeAt a = edge_at(object), b = edge_at(tool);
  return std::min(a.length, b.length) * norm(cross(a.along, rotate(X_OT.q, b.along)));
}

/// Part of a surface at a point that is known up to rounding: a corner if one is that near.
Feature feature_at(const TriangleMesh& mesh, const ClosestPoint& on) {
  for (const uint32_t v : mesh.triangles[on.triangle]) {
    if (norm(mesh.vertices[v] - on.point_O) < kCorner) return {FeatureKind::kVertex, v};
  }
  return on.feature;
}

bool is_corner(const ContactSide& side, const PlanePatch& patch) {
  return side.feature.kind == FeatureKind::kVertex && patch.extent < kCorner;
}

}  // namespace

PlanePatch contact_reach(const ContactSide& object, const ContactSide& tool, const Pose& X_OT) {
  const PlanePatch a = plane_patch(object.mesh, object.triangle, object.point, object.normal);
  const PlanePatch b = plane_patch(tool.mesh, tool.triangle, tool.point, tool.normal);
  PlanePatch both;
  both.extent = std::max({a.extent, b.extent, crossing_extent(object, tool, X_OT)});
  both.extent = std::clamp(both.extent, kMinExtent, kMaxExtent);
  const bool is_a = is_corner(object, a), is_b = is_corner(tool, b);
  if (is_a != is_b) {
    both.curvature = is_a ? b.curvature : a.curvature;
  } else if (a.curvature > 0 && b.curvature > 0) {
    both.curvature = a.curvature * b.curvature / (a.curvature + b.curvature);
  }
  return both;
}

PlanePatch contact_reach(const MeshShape& object, const MeshShape& tool, const Pose& X_OT,
                         const Vec3& object_point_O, const Vec3& tool_point_O, const Vec3& normal_O,
                         double search) {
  HAPTIC_ASSERT(search > 0);
  const Pose X_TO = inverse(X_OT);
  const ClosestPoint a = closest_point(object, object_point_O, search);
  const ClosestPoint b = closest_point(tool, X_TO * tool_point_O, search);
  if (!a.found || !b.found) return {};
  return contact_reach(
      ContactSide{object.mesh, a.triangle, feature_at(object.mesh, a), a.point_O, normal_O},
      ContactSide{tool.mesh, b.triangle, feature_at(tool.mesh, b), b.point_O,
                  rotate(X_TO.q, -normal_O)},
      X_OT);
}

}  // namespace haptic

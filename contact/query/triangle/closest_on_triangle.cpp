// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/closest_on_triangle.h"

#include <array>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Closest point of one side; sides and corners numbered as in TriangleMesh.
OnTriangle closest_on_side(const Vec3& p, const Corners& corners, uint32_t side) {
  const uint32_t next = (side + 1) % 3;
  const Vec3 ab = corners[next] - corners[side];
  const double along = dot(ab, p - corners[side]), length_squared = norm_squared(ab);
  if (!(along > 0)) return {corners[side], FeatureKind::kVertex, side};
  if (along >= length_squared) return {corners[next], FeatureKind::kVertex, next};
  return {corners[side] + (along / length_squared) * ab, FeatureKind::kEdge, side};
}

/// Closest point of the three sides: a triangle without area has no Voronoi regions.
OnTriangle closest_on_border(const Vec3& p, const Corners& corners) {
  OnTriangle best = closest_on_side(p, corners, 0);
  for (const uint32_t side : {1u, 2u}) {
    const OnTriangle other = closest_on_side(p, corners, side);
    if (norm_squared(p - other.point) < norm_squared(p - best.point)) best = other;
  }
  return best;
}

/// Voronoi regions of the corners, sides and face (Ericson 2005, §5.1.5).
OnTriangle closest_on_triangle(const Vec3& p, const Corners& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {a, FeatureKind::kVertex, 0};
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {b, FeatureKind::kVertex, 1};
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {c, FeatureKind::kVertex, 2};
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (!(va + vb + vc > 0)) return closest_on_border(p, corners);
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 / (d1 - d3)) * ab, FeatureKind::kEdge, 0};
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return {b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), FeatureKind::kEdge, 1};
  }
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 / (d2 - d6)) * ac, FeatureKind::kEdge, 2};
  const double sum = va + vb + vc;
  return {a + (vb / sum) * ab + (vc / sum) * ac, FeatureKind::kFace, 0};
}

}  // namespace

const Vec3& pseudo_normal(const TriangleMesh& mesh, const Feature& feature) {
  switch (feature.kind) {
    case FeatureKind::kVertex:
      return mesh.vertex_normals[feature.index];
    case FeatureKind::kEdge:
      return mesh.edge_normals[feature.index];
    default:
      return mesh.face_normals[feature.index];
  }
}

OnTriangle closest_on_triangle(const TriangleMesh& mesh, uint32_t triangle, const Vec3& p_O) {
  return closest_on_triangle(p_O, corners_of(mesh, triangle));
}

Feature feature_of(const TriangleMesh& mesh, uint32_t triangle, const OnTriangle& on) {
  switch (on.kind) {
    case FeatureKind::kVertex:
      return {on.kind, mesh.triangles[triangle][on.index]};
    case FeatureKind::kEdge:
      return {on.kind, mesh.triangle_edges[triangle][on.index]};
    default:
      return {on.kind, triangle};
  }
}

ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const OnTriangle& on, const Vec3& p_O) {
  HAPTIC_ASSERT(triangle < mesh.triangles.size());
  ClosestPoint result;
  result.found = true;
  result.point_O = on.point;
  result.distance = norm(p_O - on.point);
  result.triangle = triangle;
  result.feature = feature_of(mesh, triangle, on);
  // an open surface has no inside
  result.inside = mesh.closed && dot(p_O - on.point, pseudo_normal(mesh, result.feature)) < 0;
  return result;
}

ClosestPoint closest_point_on_triangle(const TriangleMesh& mesh, uint32_t triangle,
                                       const Vec3& p_O) {
  return closest_point_on_triangle(mesh, triangle, closest_on_triangle(mesh, triangle, p_O), p_O);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/point_scene.h"

#include "proto/math/assert.h"

namespace haptic {

ProxySupport support_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W) {
  HAPTIC_ASSERT(plane.object < scene.shapes.size() && scene.radius >= 0);
  const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
  const Vec3 g_O = inverse(scene.X_WO[plane.object]) * g_W;
  const Feature face{FeatureKind::kFace, plane.triangle};
  const Vec3& n_O = mesh.face_normals[plane.triangle];
  const double height = dot(n_O, g_O - mesh.vertices[mesh.triangles[plane.triangle][0]]);
  if (scene.radius == 0) return {face, g_O - height * n_O, n_O};
  const ClosestPoint c = closest_point_on_triangle(mesh, plane.triangle, g_O);
  if (c.feature == face) return {face, c.point_O, n_O};
  return {c.feature, c.point_O,
          c.distance > 0 ? (g_O - c.point_O) / c.distance : pseudo_normal(mesh, c.feature)};
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/point/triangles_within.h"

#include "contact/query/point/patch_tests.h"

namespace haptic {
namespace {

/// False if a neighbouring triangle shows that the closest point `on` is not a local minimum, or if
/// the point lies behind its face.
bool neighbours_agree(const TriangleMesh& mesh, uint32_t triangle, const OnTriangle& on,
                      const Vec3& p_O) {
  if (on.kind == FeatureKind::kFace) {
    return dot(p_O - on.point, mesh.face_normals[triangle]) >= 0;
  }
  const auto agrees_across = [&](uint32_t side) {
    const uint32_t other = neighbour_across(mesh, triangle, side);
    if (other == kNoFace) return true;
    const OnTriangle there = closest_on_triangle(mesh, other, p_O);
    return feature_of(mesh, other, there) == feature_of(mesh, triangle, on);
  };
  return agrees_across(on.index) &&
         (on.kind == FeatureKind::kEdge || agrees_across((on.index + 2) % 3));
}

/// Common part of triangles_within and triangles_facing.
size_t collect(const MeshShape& shape, const Vec3& p_O, double radius, Facing facing,
               std::span<ClosestPoint> out) {
  if (shape.patches.nodes.empty() || !(radius > 0) || !is_finite(p_O)) return 0;
  const double radius_squared = radius * radius;
  const PatchProbe probe(p_O);
  const float limit = round_up_distance(radius);
  size_t found = 0;
  const auto near = [&](const PatchNode& node) { return patches_near(node, probe, limit, facing); };
  for_each_near_leaf(shape.patches, near, [&](const PatchLeaf& leaf) {
    LaneSet lanes = triangles_near(leaf, probe, limit);
    for (; lanes.any(); lanes.pop()) {
      const uint32_t triangle = leaf.triangle[lanes.first()];
      const OnTriangle on = closest_on_triangle(shape.mesh, triangle, p_O);
      if (!(norm_squared(p_O - on.point) < radius_squared)) continue;
      if (facing == Facing::kFront && !neighbours_agree(shape.mesh, triangle, on, p_O)) continue;
      if (found < out.size()) out[found] = closest_point_on_triangle(shape.mesh, triangle, on, p_O);
      ++found;
    }
  });
  return found;
}

}  // namespace

size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out) {
  return collect(shape, p_O, radius, Facing::kAny, out);
}

size_t triangles_facing(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out) {
  return collect(shape, p_O, radius, Facing::kFront, out);
}

}  // namespace haptic

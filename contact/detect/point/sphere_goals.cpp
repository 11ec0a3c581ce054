// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/sphere_goals.h"

#include "contact/detect/point/sphere_rest.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kLargestBend = 0.5;  // least cosine of the bend around an edge taken in one leg
constexpr double kLeastRoll = 0.02;   // of the radius: least length of a leg around an edge
constexpr double kFarRest = 0.01;   // of the radius: farther places of rest may lie behind another
constexpr double kLongestLeap = 2;  // most that a subgoal is extended for a crease, as a ratio

/// The subgoal, at least `roll` away: where the tool is beside or behind an edge the subgoal is
/// only as far as the tool is from the edge, and rolling around it would take endless legs.
Vec3 rolled_on(const PointScene& scene, const Vec3& g_W, const Vec3& subgoal_W, double roll) {
  const Vec3 way_W = subgoal_W - g_W;
  const double way = norm(way_W);
  return way > ProxyLeg::kNoProgress * scene.epsilon && way < roll ? g_W + (roll / way) * way_W
                                                                   : subgoal_W;
}

RoundObstacle obstacle_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W) {
  const ProxySupport support = support_of(scene, plane, g_W);
  const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
  const Pose& X_WO = scene.X_WO[plane.object];
  Vec3 direction_O = support.normal_O;
  for (size_t i = 0; support.feature.kind == FeatureKind::kEdge && i < 3; ++i) {
    if (mesh.triangle_edges[plane.triangle][i] != support.feature.index) continue;
    const Triangle& corners = mesh.triangles[plane.triangle];
    direction_O = normalized(mesh.vertices[corners[(i + 1) % 3]] - mesh.vertices[corners[i]]);
  }
  return {support.feature.kind, X_WO * support.point_O, rotate(X_WO.q, direction_O)};
}

/// Where a sphere comes to rest between the obstacles of some facets.
SphereRest rest_between(const PointScene& scene, std::span<const ProxyPlane> planes,
                        const Vec3& g_W, const Vec3& tool_W) {
  std::array<RoundObstacle, 3> obstacles;
  HAPTIC_ASSERT(planes.size() <= obstacles.size());
  for (size_t i = 0; i < planes.size(); ++i) obstacles[i] = obstacle_of(scene, planes[i], g_W);
  return rest_in_crease({obstacles.data(), planes.size()}, scene.radius + scene.epsilon, g_W,
                        tool_W);
}

}  // namespace

Vec3 beyond_bend(const PointScene& scene, const ProxyPlane& plane, const HalfSpace& tangent,
                 const Vec3& g_W, const Vec3& p_W, const Vec3& subgoal_W) {
  if (scene.radius == 0) return subgoal_W;
  const Pose& X_WO = scene.X_WO[plane.object];
  const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
  const ClosestPoint c = closest_point_on_triangle(mesh, plane.triangle, inverse(X_WO) * p_W);
  if (c.feature.kind == FeatureKind::kFace || c.distance == 0) return subgoal_W;
  const Vec3 foot_W = X_WO * c.point_O;
  const Vec3 outward_W = (p_W - foot_W) / c.distance;
  const double bend = dot(tangent.normal, outward_W);
  if (bend < kLargestBend) return rolled_on(scene, g_W, subgoal_W, kLeastRoll * scene.radius);
  return foot_W + ((tangent.offset - dot(tangent.normal, foot_W)) / bend) * outward_W;
}

Vec3 beyond_crease(const PointScene& scene, const ProxyLeg& pushing, const ProxyLeg& before,
                   const Vec3& g_W, const Vec3& tool_W, const Vec3& subgoal_W) {
  const auto is_round = [&](const ProxyPlane& plane) {
    return support_of(scene, plane, g_W).feature.kind != FeatureKind::kFace;
  };
  const auto end = pushing.planes.begin() + static_cast<std::ptrdiff_t>(pushing.size);
  // between faces the subgoals are exact
  if (scene.radius == 0 || pushing.size < 2 ||
      std::none_of(pushing.planes.begin(), end, is_round)) {
    return subgoal_W;
  }
  std::array<ProxyPlane, 3> corner = {pushing.planes[0], pushing.planes[1], pushing.planes[2]};
  size_t size = pushing.size;
  for (size_t i = 0; i < before.size && size < corner.size(); ++i) {
    const auto known = std::span(corner).first(size);
    if (std::find(known.begin(), known.end(), before.planes[i]) == known.end()) {
      corner[size++] = before.planes[i];
    }
  }
  SphereRest rest;
  for (; size >= pushing.size && !rest.found; --size) {
    rest = rest_between(scene, std::span(corner).first(size), g_W, tool_W);
  }
  if (!rest.found) return rolled_on(scene, g_W, subgoal_W, kLeastRoll * scene.radius);
  // the sphere may be nearer to one of them than where it will rest
  const Vec3 out_W = rest.centre_W - tool_W;
  if (norm(out_W) > norm(g_W - tool_W) + scene.epsilon) return subgoal_W;
  // already there: the subgoal decides whether it rests, or is at the seam of two flat facets
  const double way = norm(rest.centre_W - g_W);
  if (way <= ProxyLeg::kNoProgress * scene.epsilon) return subgoal_W;
  if (way > kFarRest * scene.radius) {
    return rolled_on(scene, g_W, subgoal_W, std::min(kLeastRoll * scene.radius, way / 2));
  }
  double leap = 1;
  for (const HalfSpace& plane : pushing.view()) {
    const double rise = dot(plane.normal, out_W);
    if (!(rise > 0)) return subgoal_W;
    leap = std::max(leap, (plane.offset - dot(plane.normal, tool_W)) / rise);
  }
  return leap <= kLongestLeap ? tool_W + leap * out_W : subgoal_W;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point_proxy.h"

#include <algorithm>
#include <limits>

#include "contact/query/segment_hit.h"
#include "proto/math/project_point.h"

namespace haptic {
namespace {

constexpr int kMaxSweeps = 48;        // bound of a step; a corner of three facets needs about seven
constexpr size_t kMaxPlanes = 12;     // met in one leg; more are dropped by restarting the leg
constexpr int kMaxSeedAttempts = 8;   // objects that may overlap where the hand starts
constexpr double kNoProgress = 1e-3;  // of epsilon
constexpr double kClearance = 0.5;    // of epsilon: nearer to a facet than this counts as blocked

struct SceneHit {
  bool hit = false;
  double t = 1;
  ProxyPlane plane;
};

SceneHit first_hit_in_scene(const PointScene& scene, const Vec3& from_W, const Vec3& to_W) {
  SceneHit first;
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Pose X_OW = inverse(scene.X_WO[i]);
    const SegmentHit hit = first_hit(scene.shapes[i], X_OW * from_W, X_OW * to_W);
    if (hit.hit && (!first.hit || hit.t < first.t)) first = {true, hit.t, {i, hit.triangle}};
  }
  return first;
}

HalfSpace facet_plane(const PointScene& scene, const ProxyPlane& plane) {
  const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
  const Pose& X_WO = scene.X_WO[plane.object];
  const Vec3 normal_W = rotate(X_WO.q, mesh.face_normals[plane.triangle]);
  const Vec3 corner_W = X_WO * mesh.vertices[mesh.triangles[plane.triangle][0]];
  return {normal_W, dot(normal_W, corner_W)};
}

/// A facet that p_W nearly touches, if any. A swept segment may graze an edge and end on the
/// surface to the last bit: such a point is not free for sure, and the next sweep could start
/// inside.
SceneHit touched_facet(const PointScene& scene, const Vec3& p_W) {
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 p_O = inverse(scene.X_WO[i]) * p_W;
    const ClosestPoint c = closest_point(scene.shapes[i], p_O, kClearance * scene.epsilon);
    if (c.found) return {true, 0, {i, c.triangle}};
  }
  return {};
}

/// The planes met in one leg, kept off the surface by epsilon.
struct Leg {
  std::array<HalfSpace, kMaxPlanes> half_spaces;
  std::array<ProxyPlane, kMaxPlanes> planes;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
};

/// Where the way from → to ends: epsilon in front of the facet that was hit, never moving back.
Vec3 stop_short(const PointScene& scene, const SceneHit& hit, const Vec3& from_W,
                const Vec3& to_W) {
  const HalfSpace plane = facet_plane(scene, hit.plane);
  const double height = dot(plane.normal, from_W) - plane.offset;
  const double drop = dot(plane.normal, from_W - to_W);
  const double t = drop > 0 ? std::clamp((height - scene.epsilon) / drop, 0.0, hit.t) : 0.0;
  return from_W + t * (to_W - from_W);
}

/// How far in front of a facet's plane the proxy is kept, from the height it has: never lifted, or
/// two facets would hand it to and fro; only where it begins on the surface it is taken off.
double stand_off(const PointScene& scene, double height) {
  if (height >= 0 && height < kClearance * scene.epsilon) return scene.epsilon;
  return std::min(height, scene.epsilon);
}

/// Too many facets in one leg: forget those that do not push.
Leg pushing_planes(const Leg& leg, const PointProjection& goal) {
  Leg kept;
  for (int i = 0; i < goal.n_active; ++i) {
    const auto k = static_cast<size_t>(goal.active[static_cast<size_t>(i)]);
    kept.half_spaces[kept.size] = leg.half_spaces[k];
    kept.planes[kept.size++] = leg.planes[k];
  }
  return kept;
}

/// Whether a point lies inside a closed object; a surface without an inside has none.
bool is_inside(const PointScene& scene, uint32_t object, const Vec3& p_W) {
  const MeshShape& shape = scene.shapes[object];
  if (!shape.mesh.closed) return false;
  const Vec3 p_O = inverse(scene.X_WO[object]) * p_W;
  return closest_point(shape, p_O, std::numeric_limits<double>::infinity()).inside;
}

/// Objects that moved over the proxy take it along: in their frame it stays where it was. Two that
/// press it into each other leave it no free pose.
uint32_t carry_with_objects(const PointScene& scene, PointProxy& proxy) {
  const Vec3 start_W = proxy.g_W;
  // the way of the proxy as an object sees it, from before anything moved to now
  const auto runs_over = [&](uint32_t i) {
    const Vec3 before_O = inverse(proxy.X_WO[i]) * start_W;
    const Vec3 after_O = inverse(scene.X_WO[i]) * proxy.g_W;
    return first_hit(scene.shapes[i], before_O, after_O).hit;
  };
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    if (proxy.X_WO[i] == scene.X_WO[i] || !runs_over(i)) continue;
    proxy.g_W = scene.X_WO[i] * (inverse(proxy.X_WO[i]) * start_W);
  }
  uint32_t flags = 0;
  if (proxy.g_W != start_W) {
    for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
      if (runs_over(i) || is_inside(scene, i, proxy.g_W)) flags = kContactNoFreePose;
    }
  }
  proxy.X_WO = scene.X_WO;
  return flags;
}

}  // namespace

uint32_t seed_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy) {
  proxy.g_W = p_W;
  proxy.X_WO = scene.X_WO;
  proxy.seeded = false;
  uint32_t flags = 0;
  for (int attempt = 0; attempt < kMaxSeedAttempts; ++attempt) {
    bool moved = false;
    for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
      const MeshShape& shape = scene.shapes[i];
      if (!shape.mesh.closed) continue;
      const Vec3 p_O = inverse(scene.X_WO[i]) * proxy.g_W;
      const ClosestPoint c = closest_point(shape, p_O, std::numeric_limits<double>::infinity());
      if (!c.inside) continue;
      // out through the nearest surface point, along the facet's normal
      const Vec3 out_O = c.point_O + scene.epsilon * shape.mesh.face_normals[c.triangle];
      proxy.g_W = scene.X_WO[i] * out_O;
      flags |= kContactReseeded;
      moved = true;
    }
    if (!moved) {
      proxy.seeded = true;
      return flags;
    }
  }
  return flags | kContactNoFreePose;
}

ProxyMove move_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy) {
  ProxyMove move;
  move.flags = carry_with_objects(scene, proxy);
  const Vec3 start_W = proxy.g_W;
  const double to_go = norm(p_W - start_W);

  Leg leg;
  PointProjection goal;
  goal.x = p_W;
  int sweeps = 0;
  // never ends between two legs, without a plane
  for (; sweeps < kMaxSweeps || leg.size == 0; ++sweeps) {
    SceneHit blocked = first_hit_in_scene(scene, proxy.g_W, goal.x);
    const Vec3 reached_W = blocked.hit ? stop_short(scene, blocked, proxy.g_W, goal.x) : goal.x;
    const bool gains = norm(reached_W - proxy.g_W) > kNoProgress * scene.epsilon;
    // where it stands it is clear already
    const SceneHit touched = gains ? touched_facet(scene, reached_W) : SceneHit{};
    const bool moved = gains && !touched.hit;
    if (touched.hit) blocked = touched;
    if (moved) proxy.g_W = reached_W;
    if (!blocked.hit && (leg.size == 0 || !moved)) break;
    // planes hold where they were met, in the order met: elsewhere try for the tool itself again,
    // so that a proxy at rest does not depend on how it came there
    if (moved && (sweeps < kMaxSweeps || !blocked.hit)) {
      leg.size = 0;
      goal = {};
      goal.x = p_W;
      continue;
    }
    if (leg.size == kMaxPlanes) {
      leg = pushing_planes(leg, goal);
      move.flags |= kContactTruncated;
    }
    HalfSpace plane = facet_plane(scene, blocked.plane);
    plane.offset += stand_off(scene, dot(plane.normal, proxy.g_W) - plane.offset);
    leg.half_spaces[leg.size] = plane;
    leg.planes[leg.size++] = blocked.plane;
    goal = project_onto_half_spaces(p_W, leg.view());
    if (!goal.converged || norm(goal.x - proxy.g_W) <= kNoProgress * scene.epsilon) break;
  }
  if (sweeps >= kMaxSweeps) move.flags |= kContactIterationLimit;

  const Leg carrying = pushing_planes(leg, goal);
  move.n_active = static_cast<uint32_t>(carrying.size);
  std::copy_n(carrying.planes.begin(), carrying.size, move.active.begin());
  move.free_fraction = to_go > 0 ? std::min(1.0, norm(proxy.g_W - start_W) / to_go) : 1.0;
  return move;
}

}  // namespace haptic

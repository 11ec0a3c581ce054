// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/point_proxy.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "contact/detect/point/sphere_rest.h"
#include "contact/query/sweep/swept_sphere.h"
#include "contact/query/triangle/vertex_fan.h"
#include "proto/math/assert.h"
#include "proto/math/project_point.h"

namespace haptic {
namespace {

constexpr int kMaxSweeps = 48;  // sweeps per step; a corner of three facets needs about seven
constexpr int kMaxSphereSweeps = 192;  // a sphere's edges and vertices are round: it needs more
constexpr size_t kMaxPlanes = 12;      // per leg; beyond, those that do not push are dropped
constexpr int kMaxSeedAttempts = 8;    // objects that may overlap at the start
constexpr double kNoProgress = 1e-3;   // of epsilon: shorter moves are no progress
constexpr int kMaxStalls = 3;          // legs without progress before the proxy rests
constexpr double kLargestBend = 0.5;   // least cosine of the bend around an edge taken in one leg
constexpr double kLeastRoll = 0.02;    // of the radius: least length of a leg around an edge
constexpr double kFarRest = 0.01;   // of the radius: farther places of rest may lie behind another
constexpr double kLongestLeap = 2;  // most that a subgoal is extended for a crease, as a ratio
constexpr int kSettlingRounds = 3;  // iterations of tangent planes in settle()
constexpr double kClearance = 0.5;  // of epsilon: nearer to a facet counts as blocked
constexpr double kAroundVertex = 1e3;  // of epsilon: distance at which it goes around a vertex, ten
                                       // times that at which two walls at half a degree hold it off
constexpr double kLeastProgress = 4;   // least progress beyond a vertex, in distances kAroundVertex
constexpr int kMaxLeaves = 8;          // vertices left per step; rarely more than one
constexpr double kBeside = 4;          // of epsilon: search radius; the proxy stands off by one

using Witnesses = std::array<ProxyWitness, kMaxObjects>;

struct SceneHit {
  bool hit = false;
  double t = 1;
  ProxyPlane plane;
};

SegmentHit first_hit_of_object(const PointScene& scene, uint32_t object, const Vec3& from_O,
                               const Vec3& to_O, SegmentWitness& witness) {
  const MeshShape& shape = scene.shapes[object];
  SegmentWitness tried = witness;
  const SegmentHit hit = scene.radius > 0
                             ? first_sphere_hit(shape, {from_O, to_O, scene.radius}, tried)
                             : first_hit(shape, from_O, to_O, tried);
  // kept after a free sweep: it is probably blocked there again
  if (hit.hit) witness = tried;
  return hit;
}

/// `planes`: number of planes of the leg so far, which selects the witness.
SceneHit first_hit_in_scene(const PointScene& scene, const Vec3& from_W, const Vec3& to_W,
                            size_t planes, Witnesses& witnesses) {
  HAPTIC_ASSERT(scene.shapes.size() <= kMaxObjects);
  SceneHit first;
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Pose X_OW = inverse(scene.X_WO[i]);
    SegmentWitness& witness = witnesses[i].hit[std::min(planes, witnesses[i].hit.size() - 1)];
    const SegmentHit hit = first_hit_of_object(scene, i, X_OW * from_W, X_OW * to_W, witness);
    if (hit.hit && (!first.hit || hit.t < first.t)) first = {true, hit.t, {i, hit.triangle}};
  }
  return first;
}

/// Half-space for the centre of a proxy at x_W: the tangent plane of the facet's obstacle.
HalfSpace tangent_plane(const PointScene& scene, const ProxyPlane& plane, const Vec3& x_W) {
  const Pose& X_WO = scene.X_WO[plane.object];
  if (scene.radius == 0) {
    const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
    const Vec3 face_W = rotate(X_WO.q, mesh.face_normals[plane.triangle]);
    const Vec3& corner_O = mesh.vertices[mesh.triangles[plane.triangle][0]];
    return {face_W, dot(face_W, X_WO * corner_O)};
  }
  const ProxySupport support = support_of(scene, plane, x_W);
  const Vec3 normal_W = rotate(X_WO.q, support.normal_O);
  return {normal_W, dot(normal_W, X_WO * support.point_O) + scene.radius};
}

/// A facet that a point at p_W nearly touches, if any. A swept point may graze an edge and end
/// exactly on the surface: such a place may not be free, and the next sweep might start inside. Not
/// needed for a sphere: what overlaps it is hit at once.
SceneHit touched_facet(const PointScene& scene, const Vec3& p_W, Witnesses& witnesses) {
  if (scene.radius > 0) return {};
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 p_O = inverse(scene.X_WO[i]) * p_W;
    // the result is also the warm start of the next search
    const ClosestPoint c =
        closest_point(scene.shapes[i], p_O, kBeside * scene.epsilon, witnesses[i].beside);
    const bool touches = c.found && c.distance <= kClearance * scene.epsilon;
    if (touches) return {true, 0, {i, c.triangle}};
  }
  return {};
}

/// The planes met in one leg, offset by epsilon.
struct Leg {
  std::array<HalfSpace, kMaxPlanes> half_spaces;
  std::array<ProxyPlane, kMaxPlanes> planes;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
  bool holds(const ProxyPlane& plane) const {
    const auto known = std::span(planes).first(size);
    return std::find(known.begin(), known.end(), plane) != known.end();
  }
};

/// End of the motion from → to: epsilon in front of the obstacle that was hit, never moving back.
Vec3 stop_short(const PointScene& scene, const SceneHit& hit, const Vec3& from_W,
                const Vec3& to_W) {
  double t = 0;
  if (scene.radius > 0) {
    const Pose X_OW = inverse(scene.X_WO[hit.plane.object]);
    const SweptSphere grown{X_OW * from_W, X_OW * to_W, scene.radius + scene.epsilon};
    const TriangleMesh& mesh = scene.shapes[hit.plane.object].mesh;
    t = hit.t;
    if (!sphere_enters_triangle(mesh, hit.plane.triangle, grown, t)) t = 0;
  } else {
    const HalfSpace plane = tangent_plane(scene, hit.plane, from_W);
    const double height = dot(plane.normal, from_W) - plane.offset;
    const double drop = dot(plane.normal, from_W - to_W);
    if (drop > 0) t = std::max((height - scene.epsilon) / drop, 0.0);
  }
  return from_W + std::min(t, hit.t) * (to_W - from_W);
}

/// The subgoal, at least `roll` away: where the tool is beside or behind an edge the subgoal is
/// only as far as the tool is from the edge, and rolling around it would take endless legs.
Vec3 rolled_on(const PointScene& scene, const Vec3& g_W, const Vec3& subgoal_W, double roll) {
  const Vec3 way_W = subgoal_W - g_W;
  const double way = norm(way_W);
  return way > kNoProgress * scene.epsilon && way < roll ? g_W + (roll / way) * way_W : subgoal_W;
}

/// Subgoal at an edge or vertex: its tangent plane turns while a sphere rolls around it, so the
/// nearest point on the plane is only a small part of the way. The line from the feature through
/// the tool meets the plane where the motion towards the tool ends at the place of rest. Where the
/// tool is beside or behind the feature the sphere rolls on by a least step. The given subgoal if
/// there is no such bend.
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

/// A goal beyond the place of rest in a crease of two obstacles or a corner of three, at least one
/// of them round: on the line from the tool through that place, as far out as the tangent planes
/// require. In a corner the sphere touches only two at a time: the third may be one of the previous
/// leg.
Vec3 beyond_crease(const PointScene& scene, const Leg& pushing, const Leg& before, const Vec3& g_W,
                   const Vec3& tool_W, const Vec3& subgoal_W) {
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
  if (way <= kNoProgress * scene.epsilon) return subgoal_W;
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

/// Offset of a facet's plane, given the proxy's height over it: the proxy is lifted off the surface
/// itself only, or two facets would pass it back and forth.
double stand_off(const PointScene& scene, double height) {
  if (height >= 0 && height < kClearance * scene.epsilon) return scene.epsilon;
  return std::min(height, scene.epsilon);
}

size_t nearest_corner(const TriangleMesh& mesh, uint32_t triangle, const Vec3& p_O) {
  const auto away = [&](size_t i) {
    return norm(mesh.vertices[mesh.triangles[triangle][i]] - p_O);
  };
  size_t nearest = away(1) < away(0) ? 1 : 0;
  return away(2) < away(nearest) ? 2 : nearest;
}

/// The planes of a leg that push.
Leg pushing_planes(const Leg& leg, const PointProjection& goal) {
  Leg kept;
  for (int i = 0; i < goal.n_active; ++i) {
    const auto k = static_cast<size_t>(goal.active[static_cast<size_t>(i)]);
    HAPTIC_ASSERT(k < leg.size);
    kept.half_spaces[kept.size] = leg.half_spaces[k];
    kept.planes[kept.size++] = leg.planes[k];
  }
  return kept;
}

/// The nearest surface point if a proxy at p_W overlaps an object: inside a closed one (an open
/// surface has no inside), or nearer than its radius.
ClosestPoint overlap(const PointScene& scene, uint32_t object, const Vec3& p_W) {
  const MeshShape& shape = scene.shapes[object];
  if (!shape.mesh.closed && scene.radius == 0) return {};
  const Vec3 p_O = inverse(scene.X_WO[object]) * p_W;
  const ClosestPoint c = closest_point(
      shape, p_O, shape.mesh.closed ? std::numeric_limits<double>::infinity() : scene.radius);
  return c.inside || c.distance < scene.radius ? c : ClosestPoint{};
}

/// Objects that moved over the proxy carry it along: it keeps its place in their frame. Two that
/// squeeze it leave no free pose.
uint32_t carry_with_objects(const PointScene& scene, PointProxy& proxy) {
  const Vec3 start_W = proxy.g_W;
  // motion of the proxy in the frame of an object, from before the objects moved
  const auto runs_over = [&](uint32_t i) {
    const Vec3 before_O = inverse(proxy.X_WO[i]) * start_W;
    const Vec3 after_O = inverse(scene.X_WO[i]) * proxy.g_W;
    return first_hit_of_object(scene, i, before_O, after_O, proxy.witnesses[i].hit[0]).hit;
  };
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    if (proxy.X_WO[i] == scene.X_WO[i] || !runs_over(i)) continue;
    proxy.g_W = scene.X_WO[i] * (inverse(proxy.X_WO[i]) * start_W);
  }
  uint32_t flags = 0;
  if (proxy.g_W != start_W) {
    for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
      if (runs_over(i) || overlap(scene, i, proxy.g_W).found) flags = kContactNoFreePose;
    }
  }
  proxy.X_WO = scene.X_WO;
  return flags;
}

/// The motion of the proxy towards the tool: legs, each with the planes met since it began.
class Slide {
 public:
  Slide(const PointScene& scene, const Vec3& tool_W, PointProxy& proxy)
      : scene_(scene),
        tool_W_(tool_W),
        g_W_(proxy.g_W),
        witnesses_(proxy.witnesses),
        nearest_W_(g_W_) {
    begin_leg();
  }

  /// One sweep to the subgoal, or one more plane; false when the proxy rests. Not in time: adds a
  /// plane wherever it is blocked.
  bool sweeps_on(bool in_time) {
    SceneHit blocked = first_hit_in_scene(scene_, g_W_, goal_.x, leg_.size, witnesses_);
    const Vec3 reached_W = blocked.hit ? stop_short(scene_, blocked, g_W_, goal_.x) : goal_.x;
    const bool gains = !is_nothing(norm(reached_W - g_W_));
    // its present place is known to be clear
    const SceneHit touched = gains ? touched_facet(scene_, reached_W, witnesses_) : SceneHit{};
    const bool moved = gains && !touched.hit;
    // a plane that the leg already has changes nothing: then the plane hit counts
    if (touched.hit && !(blocked.hit && leg_.holds(touched.plane))) blocked = touched;
    if (moved) g_W_ = reached_W;
    if (!blocked.hit && (leg_.size == 0 || !moved)) return goes_on_otherwise();
    // planes hold where they were met, in that order: after a move it heads for the tool itself
    // again, so that the place of rest is independent of the path
    if (moved && (in_time || !blocked.hit)) {
      const bool towards_tool = leg_.size == 0;
      if (!tries_again()) {
        settle();
        return goes_on_otherwise();
      }
      // the same facet would be hit on the rest of the way
      if (!towards_tool || !blocked.hit) return true;
    }
    add_plane(blocked.plane);
    return (goal_.converged && !is_nothing(norm(goal_.x - g_W_))) || goes_on_otherwise();
  }

  /// Undoes an extended subgoal that led farther away, and continues without; false if there is
  /// nothing to undo.
  bool take_leap_back() {
    const double further = norm(g_W_ - tool_W_) - norm(nearest_W_ - tool_W_);
    if (!leaps_ || further <= scene_.epsilon) return false;
    leaps_ = false;
    stalls_ = 0;
    g_W_ = nearest_W_;
    begin_leg();
    return true;
  }

  /// Undoes a detour around a vertex that led no nearer.
  void take_leave_back() {
    if (!left_ || is_much_nearer(g_W_, left_->g_W)) return;
    g_W_ = left_->g_W;
    leg_ = left_->leg;
    goal_ = left_->goal;
    left_.reset();
    leaves_ = kMaxLeaves;
  }

  Leg carrying() const { return pushing_planes(leg_, goal_); }
  bool has_no_plane() const { return leg_.size == 0; }
  bool truncated() const { return truncated_; }

 private:
  /// Whether a is nearer to the tool: |a − tool|² − |b − tool|², written without cancellation near
  /// a minimum.
  bool is_nearer(const Vec3& a_W, const Vec3& b_W) const {
    return dot(a_W - b_W, (a_W - tool_W_) + (b_W - tool_W_)) < 0;
  }
  bool is_nothing(double way) const { return way <= kNoProgress * scene_.epsilon; }

  /// Nearer by more than the detour around a vertex.
  bool is_much_nearer(const Vec3& a_W, const Vec3& b_W) const {
    return norm(b_W - tool_W_) - norm(a_W - tool_W_) > kAroundVertex * scene_.epsilon;
  }

  /// Last resorts when the planes say that it rests.
  bool goes_on_otherwise() { return take_leap_back() || leaves_vertex(); }

  /// Whether a motion of a few epsilon meets nothing, and touches nothing at its end.
  bool is_clear(const Vec3& from_W, const Vec3& to_W) {
    return !first_hit_in_scene(scene_, from_W, to_W, leg_.size, witnesses_).hit &&
           !touched_facet(scene_, to_W, witnesses_).hit;
  }

  /// At a vertex that is neither convex nor concave the free space is no intersection of
  /// half-spaces: facets that do not touch may hold the proxy although there is a way between them.
  /// Takes it around the vertex to where the steepest direction begins.
  bool leaves_vertex() {
    if (scene_.radius > 0) return false;
    take_leave_back();
    if (leaves_ >= kMaxLeaves) return false;
    const Leg pushing = pushing_planes(leg_, goal_);
    for (size_t i = 0; pushing.size > 1 && i < pushing.size; ++i) {
      if (leaves_vertex_of(pushing.planes[i])) return true;
    }
    return false;
  }

  bool leaves_vertex_of(const ProxyPlane& plane) {
    const Pose& X_WO = scene_.X_WO[plane.object];
    const TriangleMesh& mesh = scene_.shapes[plane.object].mesh;
    const double around = kAroundVertex * scene_.epsilon;
    const size_t corner = nearest_corner(mesh, plane.triangle, inverse(X_WO) * g_W_);
    const Vec3& vertex_O = mesh.vertices[mesh.triangles[plane.triangle][corner]];
    if (norm(X_WO * vertex_O - g_W_) > around) return false;
    const VertexFan fan(mesh, plane.triangle, corner);
    const Vec3 goal_O = inverse(X_WO) * tool_W_ - vertex_O;
    WayFromVertex way = fan.steepest(goal_O);
    for (; way.found && way.reach > kLeastProgress * around;
         way = fan.steepest(goal_O, way.reach)) {
      if (!goes_around(fan, way, X_WO)) continue;
      left_ = Left{g_W_, leg_, goal_};
      ++leaves_;
      g_W_ = nearest_W_ = X_WO * fan.at(way, around);
      stalls_ = 0;
      begin_leg();
      return true;
    }
    return false;
  }

  /// Whether it can reach the start of a direction: from the nearest visible place around the
  /// vertex, and from place to place.
  bool goes_around(const VertexFan& fan, const WayFromVertex& way, const Pose& X_WO) {
    const double around = kAroundVertex * scene_.epsilon;
    const size_t n = fan.places();
    const Vec3 start_W = X_WO * fan.at(way, around);
    if (is_clear(g_W_, start_W)) return true;
    for (size_t away = 0; away <= n; ++away) {
      // n − 1 places on is one back
      const bool back = away % 2 != 0;
      const size_t steps = away / 2;
      size_t place = (way.place + (back ? n - steps : steps)) % n;
      Vec3 at_W = X_WO * fan.at(place, around);
      if (!is_clear(g_W_, at_W)) continue;
      bool goes = true;
      for (size_t i = 0; goes && i < steps; ++i) {
        place = (place + (back ? 1 : n - 1)) % n;
        const Vec3 next_W = X_WO * fan.at(place, around);
        goes = is_clear(at_W, next_W);
        at_W = next_W;
      }
      if (goes && is_clear(at_W, start_W)) return true;
    }
    return false;
  }

  void begin_leg() {
    leg_.size = 0;
    goal_ = {};
    goal_.x = tool_W_;
  }

  /// Drops the planes, to head for the tool itself again; false when that makes no progress any
  /// more.
  bool tries_again() {
    const bool nearer = is_nearer(g_W_, nearest_W_);
    stalls_ = nearer ? 0 : stalls_ + 1;
    if (nearer) nearest_W_ = g_W_;
    if (stalls_ >= kMaxStalls) return false;
    if (leg_.size > 1) before_ = pushing_planes(leg_, goal_);
    begin_leg();
    return true;
  }

  /// Around a crease legs may alternate, equally near to the tool up to the stand-off: the sphere
  /// rests where the planes of all of them hold, if that is free and no farther.
  void settle() {
    if (scene_.radius == 0 || before_.size < 2) return;
    Leg all = before_;
    const Leg pushing = pushing_planes(leg_, goal_);
    for (size_t i = 0; i < pushing.size; ++i) {
      HAPTIC_ASSERT(all.size < kMaxPlanes);
      if (!all.holds(pushing.planes[i])) all.planes[all.size++] = pushing.planes[i];
    }
    const bool leaps = std::exchange(leaps_, false);
    for (int round = 0; round < kSettlingRounds; ++round) {
      const Leg last = leg_;
      const PointProjection last_goal = goal_;
      begin_leg();
      for (size_t i = 0; i < all.size; ++i) add_plane(all.planes[i]);
      const bool is_nearby = norm(goal_.x - tool_W_) <= norm(g_W_ - tool_W_) + scene_.epsilon;
      if (!is_nearby || first_hit_in_scene(scene_, g_W_, goal_.x, leg_.size, witnesses_).hit) {
        leg_ = last;
        goal_ = last_goal;
        break;
      }
      g_W_ = goal_.x;
    }
    leaps_ = leaps;
  }

  void add_plane(const ProxyPlane& plane) {
    if (leg_.size == kMaxPlanes) {
      leg_ = pushing_planes(leg_, goal_);
      truncated_ = true;
    }
    HalfSpace tangent = tangent_plane(scene_, plane, g_W_);
    tangent.offset += stand_off(scene_, dot(tangent.normal, g_W_) - tangent.offset);
    HAPTIC_ASSERT(leg_.size < kMaxPlanes);
    leg_.half_spaces[leg_.size] = tangent;
    leg_.planes[leg_.size++] = plane;
    goal_ = project_onto_half_spaces(tool_W_, leg_.view());
    if (leaps_ && leg_.size == 1) {
      goal_.x = beyond_bend(scene_, plane, tangent, g_W_, tool_W_, goal_.x);
    } else if (leaps_) {
      goal_.x = beyond_crease(scene_, pushing_planes(leg_, goal_), before_, g_W_, tool_W_, goal_.x);
    }
  }

  const PointScene& scene_;
  const Vec3 tool_W_;
  Vec3& g_W_;
  Witnesses& witnesses_;
  Leg leg_;
  Leg before_;  // planes that pushed in the last leg with more than one
  PointProjection goal_;
  Vec3 nearest_W_;  // nearest to the tool, of the ends of legs
  int stalls_ = 0;
  bool leaps_ = true;
  struct Left {
    Vec3 g_W;
    Leg leg;
    PointProjection goal;
  };
  std::optional<Left> left_;  // state before the last detour around a vertex
  int leaves_ = 0;
  bool truncated_ = false;
};

}  // namespace

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

uint32_t seed_proxy(const PointScene& scene, const Vec3& p_W, PointProxy& proxy) {
  HAPTIC_ASSERT(scene.shapes.size() <= kMaxObjects);
  HAPTIC_ASSERT(scene.epsilon >= 0 && scene.radius >= 0);
  HAPTIC_ASSERT(is_finite(p_W));
  proxy.g_W = p_W;
  proxy.X_WO = scene.X_WO;
  proxy.seeded = false;
  uint32_t flags = 0;
  for (int attempt = 0; attempt < kMaxSeedAttempts; ++attempt) {
    bool moved = false;
    for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
      const ClosestPoint c = overlap(scene, i, proxy.g_W);
      if (!c.found) continue;
      // out through the nearest surface point; from inside along the facet's normal
      const Vec3 away_O = inverse(scene.X_WO[i]) * proxy.g_W - c.point_O;
      const Vec3 out_O = c.inside || c.distance == 0 ? scene.shapes[i].mesh.face_normals[c.triangle]
                                                     : away_O / c.distance;
      proxy.g_W = scene.X_WO[i] * (c.point_O + (scene.radius + scene.epsilon) * out_O);
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
  HAPTIC_ASSERT(proxy.seeded && is_finite(p_W));
  ProxyMove move;
  move.flags = carry_with_objects(scene, proxy);
  const Vec3 start_W = proxy.g_W;
  const double to_go = norm(p_W - start_W);
  Slide slide(scene, p_W, proxy);
  const int max_sweeps = scene.radius > 0 ? kMaxSphereSweeps : kMaxSweeps;
  int sweeps = 0;
  // never ends between two legs, without a plane
  bool moves = true;
  for (; moves && (sweeps < max_sweeps || slide.has_no_plane()); ++sweeps) {
    moves = slide.sweeps_on(sweeps < max_sweeps);
  }
  if (moves) {
    move.flags |= kContactIterationLimit;
    if (slide.take_leap_back()) {
      while (slide.has_no_plane() && slide.sweeps_on(false)) continue;
    }
    slide.take_leave_back();
  }
  if (slide.truncated()) move.flags |= kContactTruncated;

  const Leg carrying = slide.carrying();
  HAPTIC_ASSERT(carrying.size <= move.active.size());
  move.n_active = static_cast<uint32_t>(carrying.size);
  std::copy_n(carrying.planes.begin(), carrying.size, move.active.begin());
  move.free_fraction = to_go > 0 ? std::min(1.0, norm(proxy.g_W - start_W) / to_go) : 1.0;
  return move;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point/point_proxy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "contact/detect/point/sphere_goals.h"
#include "contact/query/point/triangles_within.h"
#include "contact/query/sweep/swept_sphere.h"
#include "proto/math/assert.h"
#include "proto/math/project_point.h"

namespace haptic {
namespace {

constexpr int kMaxSweeps = 48;  // sweeps per step; a corner of three facets needs about seven
constexpr int kMaxSphereSweeps = 192;  // a sphere's edges and vertices are round: it needs more
constexpr int kMaxSeedAttempts = 8;    // objects that may overlap at the start
constexpr double kSameNormal = 1e-9;   // difference of unit normals: coplanar, to rounding
constexpr int kMaxStalls = 3;          // legs without progress before the proxy rests
constexpr int kSettlingRounds = 3;     // iterations of tangent planes in settle()
constexpr double kClearance = 0.5;     // of epsilon: nearer to a facet counts as blocked
constexpr double kBeside = 4;          // of epsilon: search radius; the proxy stands off by one
constexpr double kAround = 32;       // of epsilon: facets this near may bound a way on; between two
                                     // walls at four degrees it stands off by as much
constexpr double kWayOn = 256;       // of epsilon: length of a way on that is tried
constexpr double kLeastWayOn = 16;   // of epsilon: shorter ways are not worth a leg
constexpr double kLeastGain = 0.05;  // of epsilon: along a way on; what rounding gains in a pose of
                                     // 1 m is a millionth of it
constexpr int kMaxLeaves = 8;        // in a step; rarely more than two
constexpr size_t kMaxAround = 64;    // triangles around a rest; ten times those of a vertex
constexpr size_t kMaxFacets = 16;    // planes of them, three times those of a vertex

using Leg = ProxyLeg;
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

/// The triangles of an object within `radius` of p_W.
class TrianglesAround {
 public:
  TrianglesAround(const PointScene& scene, uint32_t object, const Vec3& p_W, double radius) {
    const Vec3 p_O = inverse(scene.X_WO[object]) * p_W;
    const size_t seen = triangles_within(scene.shapes[object], p_O, radius, found_);
    size_ = std::min(seen, found_.size());
  }
  std::span<const ClosestPoint> view() const { return std::span(found_).first(size_); }

 private:
  std::array<ClosestPoint, kMaxAround> found_;
  size_t size_ = 0;
};

double height_over(const HalfSpace& plane, const Vec3& p_W) {
  return dot(plane.normal, p_W) - plane.offset;
}

/// Returns true if the projection of p_O on the facet's plane lies inside the facet, `radius` or
/// more from each of its edges; `open_edge` is not looked at.
bool covers(const TriangleMesh& mesh, uint32_t triangle, const Vec3& p_O, double radius,
            uint32_t open_edge = kNoFace) {
  const Triangle& corners = mesh.triangles[triangle];
  for (size_t i = 0; i < 3; ++i) {
    if (mesh.triangle_edges[triangle][i] == open_edge) continue;
    const Vec3 &a = mesh.vertices[corners[i]], &b = mesh.vertices[corners[(i + 1) % 3]];
    const Vec3 inward = cross(mesh.face_normals[triangle], b - a);
    const double inside = dot(p_O - a, inward);
    if (!(inside > 0 && inside * inside >= radius * radius * norm_squared(inward))) return false;
  }
  return true;
}

/// Returns true if the facets that push at g_W bound all free space within `radius`: g_W is over
/// the inside of a single facet, or over the inside of a concave edge that two of them share. Such
/// a place is the local minimum, so that no other facet has to be looked at.
bool is_enclosed(const PointScene& scene, std::span<const ProxyPlane> facets, const Vec3& g_W,
                 double radius) {
  if (facets.empty() || facets.size() > 2 || facets[0].object != facets.back().object) return false;
  const TriangleMesh& mesh = scene.shapes[facets[0].object].mesh;
  const Vec3 g_O = inverse(scene.X_WO[facets[0].object]) * g_W;
  const uint32_t one = facets[0].triangle, other = facets.back().triangle;
  if (facets.size() == 1) return covers(mesh, one, g_O, radius);
  const Triangle &edges = mesh.triangle_edges[one], &others = mesh.triangle_edges[other];
  const auto shared = std::find_first_of(edges.begin(), edges.end(), others.begin(), others.end());
  if (shared == edges.end()) return false;
  const Vec3& on_edge_O =
      mesh.vertices[mesh.triangles[one][static_cast<size_t>(shared - edges.begin())]];
  double rise = 0;
  for (const uint32_t v : mesh.triangles[other]) {
    rise += dot(mesh.face_normals[one], mesh.vertices[v] - on_edge_O);
  }
  return rise > 0 && covers(mesh, one, g_O, radius, *shared) &&
         covers(mesh, other, g_O, radius, *shared);
}

/// A facet that a point which comes from from_W nearly touches at p_W, if any; of several, that
/// over which it stood highest: on an edge or vertex the plane of another may not hold it off. A
/// swept point may graze an edge and end exactly on the surface: such a place may not be free, and
/// the next sweep might start inside. Not needed for a sphere: what overlaps it is hit at once.
SceneHit touched_facet(const PointScene& scene, const Vec3& from_W, const Vec3& p_W,
                       Witnesses& witnesses) {
  if (scene.radius > 0) return {};
  const double near = kClearance * scene.epsilon;
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 p_O = inverse(scene.X_WO[i]) * p_W;
    // the result is also the warm start of the next search
    const ClosestPoint c =
        closest_point(scene.shapes[i], p_O, kBeside * scene.epsilon, witnesses[i].beside);
    if (!c.found || c.distance > near) continue;
    const auto height = [&](uint32_t triangle) {
      return height_over(tangent_plane(scene, {i, triangle}, p_W), from_W);
    };
    uint32_t highest = c.triangle;
    const TrianglesAround around(scene, i, p_W, near);
    for (const ClosestPoint& other : around.view()) {
      if (height(other.triangle) > height(highest)) highest = other.triangle;
    }
    return {true, 0, {i, highest}};
  }
  return {};
}

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
    const double height = height_over(plane, from_W);
    const double drop = dot(plane.normal, from_W - to_W);
    if (drop > 0) t = std::max((height - scene.epsilon) / drop, 0.0);
  }
  return from_W + std::min(t, hit.t) * (to_W - from_W);
}

/// Offset of a facet's plane, given the proxy's height over it: the proxy is lifted off the surface
/// itself only (to rounding), or two facets would pass it back and forth.
double stand_off(const PointScene& scene, double height) {
  const bool on_surface =
      height > -Leg::kNoProgress * scene.epsilon && height < kClearance * scene.epsilon;
  return on_surface ? scene.epsilon : std::min(height, scene.epsilon);
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
    const SceneHit touched =
        gains ? touched_facet(scene_, g_W_, reached_W, witnesses_) : SceneHit{};
    const bool moved = gains && !touched.hit;
    // a plane that the leg already has changes nothing: then the plane hit counts
    if (touched.hit && !(blocked.hit && leg_.holds(touched.plane))) blocked = touched;
    if (moved) g_W_ = reached_W;
    if (!blocked.hit && (leg_.size == 0 || !moved)) return goes_on_otherwise(in_time);
    // planes hold where they were met, in that order: after a move it heads for the tool itself
    // again, so that the place of rest is independent of the path
    if (moved && (in_time || !blocked.hit)) {
      const bool towards_tool = leg_.size == 0;
      if (!tries_again()) {
        settle();
        return goes_on_otherwise(in_time);
      }
      // the same facet would be hit on the rest of the way
      if (!towards_tool || !blocked.hit) return true;
    }
    // the same plane from the same place changes nothing
    if (!moved && leg_.holds(blocked.plane)) return goes_on_otherwise(in_time);
    add_plane(blocked.plane);
    const bool goes_on = goal_.converged && !is_nothing(norm(goal_.x - g_W_));
    return goes_on || goes_on_otherwise(in_time);
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

  Leg carrying() const { return pushing_planes(leg_, goal_); }
  bool has_no_plane() const { return leg_.size == 0; }
  bool truncated() const { return truncated_; }

 private:
  /// Whether a is nearer to the tool: |a − tool|² − |b − tool|², written without cancellation near
  /// a minimum.
  bool is_nearer(const Vec3& a_W, const Vec3& b_W) const {
    return dot(a_W - b_W, (a_W - tool_W_) + (b_W - tool_W_)) < 0;
  }
  bool is_nothing(double way) const { return way <= Leg::kNoProgress * scene_.epsilon; }

  /// Last resorts when the planes say that it rests.
  bool goes_on_otherwise(bool in_time) { return take_leap_back() || (in_time && leaves_planes()); }

  /// Whether a motion of a few epsilon meets nothing, and touches nothing at its end.
  bool is_clear(const Vec3& from_W, const Vec3& to_W) {
    return !first_hit_in_scene(scene_, from_W, to_W, leg_.size, witnesses_).hit &&
           !touched_facet(scene_, from_W, to_W, witnesses_).hit;
  }

  /// Where the free space is more than the intersection of its planes: goes on along a facet that
  /// is near, or along the line of two, if that leads nearer.
  bool leaves_planes() {
    if (scene_.radius > 0 || leg_.size == 0 || leaves_ == kMaxLeaves) return false;
    std::array<ProxyPlane, 3> pushing;
    const auto n = static_cast<size_t>(goal_.n_active);
    for (size_t i = 0; i < n; ++i) pushing[i] = leg_.planes[static_cast<size_t>(goal_.active[i])];
    const auto facets = std::span<const ProxyPlane>(pushing).first(n);
    if (is_enclosed(scene_, facets, g_W_, kAround * scene_.epsilon)) return false;
    const Facets near = facets_around(facets);
    for (size_t i = 0; i < near.size; ++i) {
      for (size_t k = 0; k <= i; ++k) {
        const std::array<HalfSpace, 2> bounds = {near.planes[i], near.planes[k]};
        if (goes_along({bounds.data(), i == k ? 1u : 2u})) return true;
      }
    }
    return false;
  }

  /// The facets around the proxy, of the objects that push, each plane once, offset by epsilon.
  struct Facets {
    std::array<HalfSpace, kMaxFacets> planes;
    size_t size = 0;
  };
  Facets facets_around(std::span<const ProxyPlane> pushing) const {
    Facets near;
    for (size_t i = 0; i < pushing.size(); ++i) {
      const uint32_t object = pushing[i].object;
      const auto same_object = [&](const ProxyPlane& plane) { return plane.object == object; };
      const auto before = pushing.first(i);
      if (std::any_of(before.begin(), before.end(), same_object)) continue;
      const TrianglesAround around(scene_, object, g_W_, kAround * scene_.epsilon);
      for (const ClosestPoint& c : around.view()) {
        HalfSpace plane = tangent_plane(scene_, {object, c.triangle}, g_W_);
        plane.offset += scene_.epsilon;
        const auto is_same = [&](const HalfSpace& known) {
          return norm(known.normal - plane.normal) < kSameNormal &&
                 std::fabs(known.offset - plane.offset) < Leg::kNoProgress * scene_.epsilon;
        };
        const auto known = std::span(near.planes).first(near.size);
        if (near.size == kMaxFacets || std::any_of(known.begin(), known.end(), is_same)) continue;
        near.planes[near.size++] = plane;
      }
    }
    return near;
  }

  /// Goes to the nearest place in front of these planes, and on towards the place nearest to the
  /// tool, if that way is clear and ends nearer.
  bool goes_along(std::span<const HalfSpace> planes) {
    const double least = norm(g_W_ - tool_W_) - kLeastGain * scene_.epsilon;
    const PointProjection last = project_onto_half_spaces(tool_W_, planes);
    if (!last.converged || norm(last.x - tool_W_) > least) return false;
    const PointProjection first = project_onto_half_spaces(g_W_, planes);
    const Vec3 way_W = last.x - first.x;
    const double way = norm(way_W);
    if (!first.converged || !(way > kLeastWayOn * scene_.epsilon)) return false;
    const Vec3 on_W = first.x + std::min(1.0, kWayOn * scene_.epsilon / way) * way_W;
    if (norm(on_W - tool_W_) > least) return false;
    const bool goes = is_clear(g_W_, on_W) || (is_clear(g_W_, first.x) && is_clear(first.x, on_W));
    if (!goes) return false;
    ++leaves_;
    g_W_ = nearest_W_ = on_W;
    stalls_ = 0;
    begin_leg();
    return true;
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
      HAPTIC_ASSERT(all.size < Leg::kMaxPlanes);
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
    if (leg_.size == Leg::kMaxPlanes) {
      leg_ = pushing_planes(leg_, goal_);
      truncated_ = true;
    }
    HalfSpace tangent = tangent_plane(scene_, plane, g_W_);
    tangent.offset += stand_off(scene_, dot(tangent.normal, g_W_) - tangent.offset);
    HAPTIC_ASSERT(leg_.size < Leg::kMaxPlanes);
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
  int leaves_ = 0;  // of planes, in this step
  bool leaps_ = true;
  bool truncated_ = false;
};

}  // namespace

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

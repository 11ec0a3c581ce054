// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/point_proxy.h"

#include <algorithm>
#include <limits>

#include "contact/query/swept_sphere.h"
#include "proto/math/project_point.h"

namespace haptic {
namespace {

constexpr int kMaxSweeps = 48;        // bound of a step; a corner of three facets needs about seven
constexpr size_t kMaxPlanes = 12;     // met in one leg; more are dropped by restarting the leg
constexpr int kMaxSeedAttempts = 8;   // objects that may overlap where the hand starts
constexpr double kNoProgress = 1e-3;  // of epsilon
constexpr int kMaxStalls = 3;         // legs that bring it no nearer before it rests
constexpr double kLargestBend = 0.5;  // cosine: around more of an edge it rolls in several legs
constexpr double kLargestTurn = 0.9;  // of a step on two edges: beyond, there is no rest nearby
constexpr double kRoll =
    0.04;  // of its radius: how far a sphere rolls at once where it cannot rest
constexpr double kHardly = 1e-4;    // of its radius
constexpr double kClearance = 0.5;  // of epsilon: nearer to a facet than this counts as blocked

using Witnesses = std::array<ProxyWitness, kMaxObjects>;
constexpr double kBeside = 4;  // of epsilon: further than the proxy stands off

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
  // after a free way it is blocked where it was before
  if (hit.hit) witness = tried;
  return hit;
}

/// After so many planes of a leg.
SceneHit first_hit_in_scene(const PointScene& scene, const Vec3& from_W, const Vec3& to_W,
                            size_t planes, Witnesses& witnesses) {
  SceneHit first;
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Pose X_OW = inverse(scene.X_WO[i]);
    SegmentWitness& witness = witnesses[i].hit[std::min(planes, witnesses[i].hit.size() - 1)];
    const SegmentHit hit = first_hit_of_object(scene, i, X_OW * from_W, X_OW * to_W, witness);
    if (hit.hit && (!first.hit || hit.t < first.t)) first = {true, hit.t, {i, hit.triangle}};
  }
  return first;
}

/// Where the centre of a proxy at x_W may be: the tangent plane of the facet's obstacle.
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

/// A facet that a point at p_W nearly touches, if any. A swept point may graze an edge and end on
/// the surface to the last bit: such a place is not free for sure, and the next sweep could start
/// inside. A sphere has no such last bit: what overlaps is hit at once.
SceneHit touched_facet(const PointScene& scene, const Vec3& p_W, Witnesses& witnesses) {
  if (scene.radius > 0) return {};
  for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
    const Vec3 p_O = inverse(scene.X_WO[i]) * p_W;
    // it mostly stands epsilon off: what is found there is where the next search begins
    const ClosestPoint c =
        closest_point(scene.shapes[i], p_O, kBeside * scene.epsilon, witnesses[i].beside);
    const bool touches = c.found && c.distance <= kClearance * scene.epsilon;
    if (touches) return {true, 0, {i, c.triangle}};
  }
  return {};
}

/// How an obstacle bends away from its tangent plane: not at all along an edge, nor for a face.
struct Bend {
  double curvature = 0;  // [1/m]
  Vec3 straight_W;       // unit, along the edge; 0 for a vertex
};

Bend bend_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W) {
  if (scene.radius == 0) return {};
  const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
  const Pose& X_WO = scene.X_WO[plane.object];
  const Vec3 g_O = inverse(X_WO) * g_W;
  const OnTriangle on = closest_on_triangle(mesh, plane.triangle, g_O);
  if (on.kind == FeatureKind::kFace) return {};
  Bend bend{1 / norm(g_O - on.point), {}};
  if (on.kind == FeatureKind::kVertex) return bend;
  const Triangle& corners = mesh.triangles[plane.triangle];
  const Vec3 along_O =
      mesh.vertices[corners[(on.index + 1) % 3]] - mesh.vertices[corners[on.index]];
  bend.straight_W = rotate(X_WO.q, normalized(along_O));
  return bend;
}

/// The planes met in one leg, kept off the surface by epsilon.
struct Leg {
  std::array<HalfSpace, kMaxPlanes> half_spaces;
  std::array<ProxyPlane, kMaxPlanes> planes;
  std::array<Bend, kMaxPlanes> bends;
  size_t size = 0;

  std::span<const HalfSpace> view() const { return {half_spaces.data(), size}; }
};

/// Where the way from → to ends: epsilon in front of the obstacle that was hit, never moving back.
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

/// How boldly the subgoals are placed: on obstacles that bend, a sphere has further to go than the
/// tangent planes tell.
enum class Leaps { kNone, kToRest, kRolls };

struct Leap {
  Vec3 tool_W, g_W;
  double roll;  // how far to go at least where there is no rest [m]
};

/// What makes a step as long as a roll; 0 where it is so long. Where the tool pulls straight
/// through an edge, nothing else takes the sphere off it in a few legs.
Vec3 lengthening(const Vec3& step_W, double roll) {
  const double length = norm(step_W);
  return length > 0 && length < roll ? (roll / length - 1) * step_W : Vec3{};
}

/// Where to go from an edge or vertex: its tangent plane turns while a sphere rolls around it, and
/// the nearest point to the tool on the plane is but a small part of the way. The line from the
/// feature through the tool meets the plane in a place from which the way to the tool ends where
/// the sphere comes to rest. The subgoal itself where there is no such bend.
Vec3 beyond_bend(const PointScene& scene, const ProxyPlane& plane, const HalfSpace& tangent,
                 const Leap& leap, const Vec3& subgoal_W) {
  const Pose& X_WO = scene.X_WO[plane.object];
  const TriangleMesh& mesh = scene.shapes[plane.object].mesh;
  const ClosestPoint c =
      closest_point_on_triangle(mesh, plane.triangle, inverse(X_WO) * leap.tool_W);
  if (c.feature.kind == FeatureKind::kFace || c.distance == 0) return subgoal_W;
  const Vec3 foot_W = X_WO * c.point_O;
  const Vec3 outward_W = (leap.tool_W - foot_W) / c.distance;
  const double bend = dot(tangent.normal, outward_W);
  // the tool is past the edge, or far around it
  if (bend < kLargestBend) return subgoal_W + lengthening(subgoal_W - leap.g_W, leap.roll);
  return foot_W + ((tangent.offset - dot(tangent.normal, foot_W)) / bend) * outward_W;
}

/// The same where two obstacles carry it: along the line that their planes share, on to where the
/// tool is nearest once they have turned as far as they bend (a Newton step of the Lagrangian with
/// its second derivatives; without them it closes in by a constant factor only).
Vec3 beyond_bends(const Leg& leg, const PointProjection& goal, const Leap& leap) {
  const auto first = static_cast<size_t>(goal.active[0]),
             second = static_cast<size_t>(goal.active[1]);
  const Vec3 shared_W = cross(leg.half_spaces[first].normal, leg.half_spaces[second].normal);
  const double length2 = norm_squared(shared_W);
  if (!(length2 > 0)) return goal.x;
  double turned = 0;
  for (size_t i = 0; i < 2; ++i) {
    const Bend& bend = leg.bends[static_cast<size_t>(goal.active[i])];
    const double straight = dot(bend.straight_W, shared_W);
    turned += goal.multiplier[i] * bend.curvature * (1 - straight * straight / length2);
  }
  const Vec3 step_W = (dot(shared_W, goal.x - leap.g_W) / length2) * shared_W;
  if (turned < kLargestTurn) return goal.x + (turned / (1 - turned)) * step_W;
  return goal.x + lengthening(step_W, leap.roll);
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
    kept.bends[kept.size] = leg.bends[k];
    kept.planes[kept.size++] = leg.planes[k];
  }
  return kept;
}

/// The nearest surface point where a proxy at p_W has no room: inside a closed object (a surface
/// without an inside has none), or nearer than its radius.
ClosestPoint overlap(const PointScene& scene, uint32_t object, const Vec3& p_W) {
  const MeshShape& shape = scene.shapes[object];
  if (!shape.mesh.closed && scene.radius == 0) return {};
  const Vec3 p_O = inverse(scene.X_WO[object]) * p_W;
  const ClosestPoint c = closest_point(
      shape, p_O, shape.mesh.closed ? std::numeric_limits<double>::infinity() : scene.radius);
  return c.inside || c.distance < scene.radius ? c : ClosestPoint{};
}

/// Objects that moved over the proxy take it along: in their frame it stays where it was. Two that
/// press it into each other leave it no free pose.
uint32_t carry_with_objects(const PointScene& scene, PointProxy& proxy) {
  const Vec3 start_W = proxy.g_W;
  // the way of the proxy as an object sees it, from before anything moved to now
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

/// The way of the proxy towards the tool: leg by leg, each a list of planes met since it began.
class Slide {
 public:
  Slide(const PointScene& scene, const Vec3& tool_W, PointProxy& proxy)
      : scene_(scene),
        tool_W_(tool_W),
        g_W_(proxy.g_W),
        witnesses_(proxy.witnesses),
        nearest_W_(g_W_),
        nearest_(distance()) {
    begin_leg();
  }

  /// One sweep to the subgoal, or one more plane; false when the proxy rests. Out of time it takes
  /// a plane wherever it is blocked.
  bool sweeps_on(bool in_time) {
    SceneHit blocked = first_hit_in_scene(scene_, g_W_, goal_.x, leg_.size, witnesses_);
    const Vec3 reached_W = blocked.hit ? stop_short(scene_, blocked, g_W_, goal_.x) : goal_.x;
    const bool gains = !is_nothing(norm(reached_W - g_W_));
    // where it stands it is clear already
    const SceneHit touched = gains ? touched_facet(scene_, reached_W, witnesses_) : SceneHit{};
    const bool moved = gains && !touched.hit;
    // an obstacle's plane holds as well where a sphere has hardly rolled
    const bool hardly = norm(reached_W - g_W_) < kHardly * scene_.radius;
    if (touched.hit) blocked = touched;
    if (moved) g_W_ = reached_W;
    if (!blocked.hit && (leg_.size == 0 || !moved)) return take_leap_back();
    // planes hold where they were met, in the order met: elsewhere it tries for the tool itself
    // again, so that a proxy at rest does not depend on how it came there
    if (moved && blocked.hit && hardly && leg_.size > 0) {
      moved_in_leg_ = true;
    } else if (moved && (in_time || !blocked.hit)) {
      const bool towards_tool = leg_.size == 0;
      if (!tries_again()) return take_leap_back();
      // on the rest of the same way the same facet is in front
      if (!towards_tool || !blocked.hit) return true;
    }
    add_plane(blocked.plane);
    if (goal_.converged && !is_nothing(norm(goal_.x - g_W_))) return true;
    return (moved_in_leg_ && tries_again()) || take_leap_back();
  }

  /// Undoes a leap beyond a bend that has led further away, to go on less boldly; false: nothing to
  /// undo.
  bool take_leap_back() {
    if (leaps_ == Leaps::kNone || is_nothing(distance() - nearest_)) return false;
    leaps_ = leaps_ == Leaps::kRolls ? Leaps::kToRest : Leaps::kNone;
    stalls_ = 0;
    g_W_ = nearest_W_;
    begin_leg();
    return true;
  }

  Leg carrying() const { return pushing_planes(leg_, goal_); }
  bool has_no_plane() const { return leg_.size == 0; }
  bool truncated() const { return truncated_; }

 private:
  double distance() const { return norm(tool_W_ - g_W_); }
  bool is_nothing(double way) const { return way <= kNoProgress * scene_.epsilon; }

  void begin_leg() {
    leg_.size = 0;
    moved_in_leg_ = false;
    goal_ = {};
    goal_.x = tool_W_;
  }

  /// Forgets the planes, to try again for the tool itself; false when that leads nowhere any more.
  bool tries_again() {
    const double now = distance();
    stalls_ = now < nearest_ ? 0 : stalls_ + 1;
    if (now < nearest_) nearest_ = now, nearest_W_ = g_W_;
    if (stalls_ >= kMaxStalls) return false;
    begin_leg();
    return true;
  }

  void add_plane(const ProxyPlane& plane) {
    if (leg_.size == kMaxPlanes) {
      leg_ = pushing_planes(leg_, goal_);
      truncated_ = true;
    }
    HalfSpace tangent = tangent_plane(scene_, plane, g_W_);
    tangent.offset += stand_off(scene_, dot(tangent.normal, g_W_) - tangent.offset);
    leg_.half_spaces[leg_.size] = tangent;
    leg_.bends[leg_.size] = bend_of(scene_, plane, g_W_);
    leg_.planes[leg_.size++] = plane;
    goal_ = project_onto_half_spaces(tool_W_, leg_.view());
    if (leaps_ == Leaps::kNone || scene_.radius == 0) return;
    const double roll = leaps_ == Leaps::kRolls ? kRoll * scene_.radius : 0;
    if (leg_.size == 1)
      goal_.x = beyond_bend(scene_, plane, tangent, {tool_W_, g_W_, roll}, goal_.x);
    if (goal_.n_active == 2) goal_.x = beyond_bends(leg_, goal_, {tool_W_, g_W_, roll});
  }

  const PointScene& scene_;
  const Vec3 tool_W_;
  Vec3& g_W_;
  Witnesses& witnesses_;
  Leg leg_;
  PointProjection goal_;
  Vec3 nearest_W_;  // to the tool, where a leg ended
  double nearest_;
  int stalls_ = 0;
  Leaps leaps_ = Leaps::kRolls;
  bool moved_in_leg_ = false;
  bool truncated_ = false;
};

}  // namespace

ProxySupport support_of(const PointScene& scene, const ProxyPlane& plane, const Vec3& g_W) {
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
  proxy.g_W = p_W;
  proxy.X_WO = scene.X_WO;
  proxy.seeded = false;
  uint32_t flags = 0;
  for (int attempt = 0; attempt < kMaxSeedAttempts; ++attempt) {
    bool moved = false;
    for (uint32_t i = 0; i < scene.shapes.size(); ++i) {
      const ClosestPoint c = overlap(scene, i, proxy.g_W);
      if (!c.found) continue;
      // out through the nearest surface point: from inside along the facet's normal
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
  ProxyMove move;
  move.flags = carry_with_objects(scene, proxy);
  const Vec3 start_W = proxy.g_W;
  const double to_go = norm(p_W - start_W);
  Slide slide(scene, p_W, proxy);
  int sweeps = 0;
  // never ends between two legs, without a plane
  bool moves = true;
  for (; moves && (sweeps < kMaxSweeps || slide.has_no_plane()); ++sweeps) {
    moves = slide.sweeps_on(sweeps < kMaxSweeps);
  }
  if (moves) {
    move.flags |= kContactIterationLimit;
    if (slide.take_leap_back()) {
      while (slide.has_no_plane() && slide.sweeps_on(false)) continue;
    }
  }
  if (slide.truncated()) move.flags |= kContactTruncated;

  const Leg carrying = slide.carrying();
  move.n_active = static_cast<uint32_t>(carrying.size);
  std::copy_n(carrying.planes.begin(), carrying.size, move.active.begin());
  move.free_fraction = to_go > 0 ? std::min(1.0, norm(proxy.g_W - start_W) / to_go) : 1.0;
  return move;
}

}  // namespace haptic

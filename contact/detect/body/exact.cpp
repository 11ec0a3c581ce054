// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "contact/shape/convex/convex_polygon.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

// relative to an edge: points over the edge between two faces belong to both
constexpr double kRim = 1e-9;
constexpr double kParallel = 1e-18;  // squared sine of the angle below which edges are parallel

struct Face {
  Corners corners;
  Vec3 normal;
};

/// A triangle clipped by three planes.
using Polygon = ConvexPolygon<6>;

/// The part of the triangle in the prism over the face.
Polygon in_prism(const Face& face, const Corners& triangle) {
  Polygon polygon;
  for (const Vec3& p : triangle) polygon.add(p);
  for (size_t i = 0; i < 3; ++i) {
    const Vec3 wall = cross(face.normal, face.corners[(i + 1) % 3] - face.corners[i]);
    polygon = polygon.clipped(wall, face.corners[i], kRim * norm_squared(wall));
  }
  return polygon;
}

/// The part of a pair's other triangle that lies behind a face.
PairPushes reach_behind(const Face& face, const Corners& triangle, double sign, double stiffness) {
  const Polygon polygon = in_prism(face, triangle);
  PairPushes reach;
  if (polygon.n == 0) reach.depth = std::numeric_limits<double>::infinity();
  Vec3 deepest = triangle[0];
  const auto push_at = [&](const Vec3& p, double depth) {
    HAPTIC_ASSERT(reach.n < kPushesPerPair);
    reach.pushes[reach.n++] = {p, sign * face.normal, depth, stiffness};
  };
  for (size_t i = 0; i < polygon.n; ++i) {
    const Vec3& p = polygon.point[i];
    const double depth = dot(face.normal, face.corners[0] - p);
    if (i == 0 || depth > reach.depth) reach.depth = std::max(depth, 0.0), deepest = p;
    // clipping passes corners on unchanged
    const bool is_corner = p == triangle[0] || p == triangle[1] || p == triangle[2];
    if (is_corner && depth >= 0 && reach.n < kPushesPerPair) push_at(p, depth);
  }
  if (reach.n == 0 && polygon.n > 0) push_at(deepest, reach.depth);
  return reach;
}

/// An edge between two triangles, in O; directed from the lower end by coordinates, so that both
/// triangles give identical numbers.
struct Edge {
  Vec3 from, to;
  std::array<Vec3, 2> beside;  // the third corners; equal on a border

  Vec3 way() const { return to - from; }
  /// Whether both triangles lie behind the plane through the edge.
  bool is_foremost_along(const Vec3& normal) const {
    return dot(normal, beside[0] - from) <= 0 && dot(normal, beside[1] - from) <= 0;
  }
};

Edge edge_of(const TriangleMesh& mesh, uint32_t triangle, size_t side, const Pose& X) {
  const Triangle& t = mesh.triangles[triangle];
  const uint32_t from = t[side], to = t[(side + 1) % 3], third = t[(side + 2) % 3];
  const uint32_t other = neighbour_across(mesh, triangle, side);
  uint32_t across = third;
  if (other != kNoFace) {
    for (const uint32_t v : mesh.triangles[other]) {
      if (v != from && v != to) across = v;
    }
  }
  Edge edge{X * mesh.vertices[from],
            X * mesh.vertices[to],
            {X * mesh.vertices[third], X * mesh.vertices[across]}};
  const Vec3 &p = edge.from, &q = edge.to;
  if (std::tie(q.x, q.y, q.z) < std::tie(p.x, p.y, p.z)) std::swap(edge.from, edge.to);
  return edge;
}

std::array<Edge, 3> edges_of(const TriangleMesh& mesh, uint32_t triangle, const Pose& X) {
  return {edge_of(mesh, triangle, 0, X), edge_of(mesh, triangle, 1, X),
          edge_of(mesh, triangle, 2, X)};
}

/// The least deep crossing of an edge of the tool and an edge of the object on its far side; depth
/// is infinite if there is none.
PairPushes reach_of_edges(const std::array<Edge, 3>& of_object, const std::array<Edge, 3>& of_tool,
                          const Vec3& to_tool, double stiffness) {
  PairPushes reach;
  reach.depth = std::numeric_limits<double>::infinity();
  for (const Edge& e : of_object) {
    for (const Edge& f : of_tool) {
      const Vec3 axis = cross(e.way(), f.way()), between = f.from - e.from;
      const double size_squared = norm_squared(axis);
      if (!(size_squared > kParallel * norm_squared(e.way()) * norm_squared(f.way()))) continue;
      const double along_e = dot(cross(between, f.way()), axis) / size_squared;
      const double along_f = dot(cross(between, e.way()), axis) / size_squared;
      if (along_e < 0 || along_e > 1 || along_f < 0 || along_f > 1) continue;
      // the common normal of both lines, oriented towards the tool
      const double sign = dot(axis, to_tool) < 0 ? -1 : 1;
      const Vec3 normal = sign / std::sqrt(size_squared) * axis;
      const double depth = -dot(normal, between);
      if (depth < 0 || depth >= reach.depth) continue;
      // else the edges do not touch there: a face or another edge is in front
      if (!e.is_foremost_along(normal) || !f.is_foremost_along(-normal)) continue;
      reach.depth = depth, reach.n = 1;
      reach.pushes[0] = {f.from + along_f * f.way(), normal, depth, stiffness};
    }
  }
  return reach;
}

bool place_before(const PointPush& a, const PointPush& b) {
  const auto key = [](const PointPush& push) {
    const Vec3 &p = push.point_O, &n = push.normal_O;
    return std::tuple(p.x, p.y, p.z, n.x, n.y, n.z, push.depth);
  };
  return key(a) < key(b);
}

/// Keeps one of the pushes at the same point along the same normal; returns the number left.
size_t merge_sorted(std::span<PointPush> pushes) {
  HAPTIC_ASSERT(std::is_sorted(pushes.begin(), pushes.end(), place_before));
  size_t n = 0, first_here = 0;
  for (const PointPush& push : pushes) {
    if (n > 0 && !(push.point_O == pushes[n - 1].point_O)) first_here = n;
    const auto here = pushes.subspan(first_here, n - first_here);
    const bool is_known = std::any_of(here.begin(), here.end(), [&](const PointPush& other) {
      return dot(push.normal_O, other.normal_O) > kOnePlane;
    });
    if (!is_known) pushes[n++] = push;
  }
  return n;
}

}  // namespace

PairPushes pushes_of_pair(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT,
                          const TrianglePair& pair, double stiffness) {
  HAPTIC_ASSERT(pair.a < object.triangles.size() && pair.b < tool.triangles.size());
  const Face on_object{corners_of(object, pair.a), object.face_normals[pair.a]};
  const Face on_tool{corners_of(tool, pair.b, X_OT), rotate(X_OT.q, tool.face_normals[pair.b])};
  const PairPushes of_tool = reach_behind(on_object, on_tool.corners, 1, stiffness);
  const PairPushes of_object = reach_behind(on_tool, on_object.corners, -1, stiffness);
  const PairPushes of_edges =
      reach_of_edges(edges_of(object, pair.a, {}), edges_of(tool, pair.b, X_OT),
                     on_object.normal - on_tool.normal, stiffness);
  const PairPushes& of_faces = of_tool.depth <= of_object.depth ? of_tool : of_object;
  return of_faces.depth <= of_edges.depth ? of_faces : of_edges;
}

size_t pushes_from_pairs(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT,
                         std::span<const TrianglePair> pairs, double stiffness,
                         std::span<PointPush> pushes) {
  size_t n = 0;
  for (const TrianglePair& pair : pairs) {
    const PairPushes least = pushes_of_pair(object, tool, X_OT, pair, stiffness);
    for (size_t i = 0; i < least.n && n < pushes.size(); ++i) pushes[n++] = least.pushes[i];
  }
  std::sort(pushes.begin(), pushes.begin() + static_cast<ptrdiff_t>(n), place_before);
  return merge_sorted(pushes.first(n));
}

ExactAnswer exact_contacts(const MeshShape& object, const MeshShape& tool, const Pose& X_OT,
                           const PushOptions& options, ClusterMemory& memory,
                           const ExactScratch& scratch, std::span<PushCluster> clusters) {
  HAPTIC_ASSERT(options.stiffness > 0);
  ExactAnswer answer;
  const size_t room = std::min(scratch.pairs.size(), scratch.pushes.size() / kPushesPerPair);
  const std::span<TrianglePair> pairs = scratch.pairs.first(room);
  answer.n_pairs = triangle_pairs(object, tool, X_OT, pairs);
  const size_t held = std::min(answer.n_pairs, room);
  answer.left_out = answer.n_pairs - held;
  answer.n_pushes = pushes_from_pairs(object.mesh, tool.mesh, X_OT, pairs.first(held),
                                      options.stiffness, scratch.pushes);
  const std::span<PointPush> pushes = scratch.pushes.first(answer.n_pushes);
  share_stiffness(pushes, options.stiffness, options.sharing);
  answer.n_clusters = cluster_pushes(pushes, options.clusters, memory, clusters);
  return answer;
}

}  // namespace haptic

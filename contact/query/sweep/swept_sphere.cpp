// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/swept_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact/query/point/segment_probe.h"
#include "contact/query/point/way_tests.h"
#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/shape/mesh/box.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

// factor of distances, covers the rounding of boxes
constexpr double kBoundSlack = kCompactSlack;
constexpr double kSquareSlack = 1e-12;  // the same, relative, of squared distances near the radius
constexpr double kRelativeSlack = 1e-14;  // the same for heights, relative to the coordinates

/// Earliest t ≥ 0 with |m + t d| = radius while approaching. Avoids cancellation: the discriminant
/// is taken at the point of nearest approach, the root in the form that is exact for a centre just
/// outside. False if there is none.
bool enters_ball(const Vec3& m, const Vec3& d, double radius, double& t) {
  const double approach = -dot(m, d), c = norm_squared(m) - radius * radius;
  if (!(approach > 0)) return false;
  if (c <= 0) {
    t = 0;
    return true;
  }
  const double length2 = norm_squared(d);
  const Vec3 nearest = m + (approach / length2) * d;
  const double inside = radius * radius - norm_squared(nearest);
  if (inside < 0) return false;
  t = c / (approach + std::sqrt(length2 * inside));
  return true;
}

bool lies_over(const Corners& corners, const Vec3& n, const Vec3& q) {
  for (size_t i = 0; i < 3; ++i) {
    const Vec3& a = corners[i];
    if (dot(n, cross(corners[(i + 1) % 3] - a, q - a)) < 0) return false;
  }
  return true;
}

/// One triangle, and the earliest hit so far.
struct TriangleSweep {
  const TriangleMesh& mesh;
  const SweptSphere& sphere;
  Vec3 d_O;
  double t = 1;
  double length = norm(d_O);
  bool hit = false;

  void take(double at) {
    if (at > t) return;
    hit = true;
    t = at;
  }
  Vec3 centre_at(double at) const { return sphere.from_O + at * d_O; }

  /// Whether an obstacle nearest at offset m from the start is out of the sphere's reach up to t.
  bool is_too_far(const Vec3& m) const {
    const double way = t * length * kBoundSlack, radius2 = sphere.radius * sphere.radius;
    return norm_squared(m) - radius2 > way * (2 * sphere.radius + way) + kSquareSlack * radius2;
  }

  void offset_face(const Corners& corners, const Vec3& n) {
    const double height = dot(n, sphere.from_O - corners[0]);
    const double drop = -dot(n, d_O);
    if (!(drop > 0) || height < 0) return;
    const double at = std::max((height - sphere.radius) / drop, 0.0);
    if (at <= t && lies_over(corners, n, centre_at(at))) take(at);
  }

  void edge_cylinder(const Vec3& a, const Vec3& b, const Vec3& front_O) {
    const Vec3 along = b - a, m = sphere.from_O - a;
    const double length2 = norm_squared(along);
    if (!(length2 > 0)) return;
    const double start = dot(m, along) / length2;
    const Vec3 across = m - start * along;
    if (is_too_far(across)) return;
    const double speed = dot(d_O, along) / length2;
    double at = 0;
    if (!enters_ball(across, d_O - speed * along, sphere.radius, at) || at > t) return;
    const double where = start + at * speed;
    if (where < 0 || where > 1) return;
    if (dot(centre_at(at) - (a + where * along), front_O) >= 0) take(at);
  }

  void vertex_sphere(const Vec3& a, const Vec3& front_O) {
    const Vec3 m = sphere.from_O - a;
    double at = 0;
    if (is_too_far(m) || !enters_ball(m, d_O, sphere.radius, at) || at > t) return;
    if (dot(centre_at(at) - a, front_O) >= 0) take(at);
  }

  void run(uint32_t triangle) {
    const Triangle& tri = mesh.triangles[triangle];
    const Corners corners = corners_of(mesh, triangle);
    const Vec3& n = mesh.face_normals[triangle];
    // rejects most triangles: the sphere stays on one side of all corners (with an allowance, since
    // the normal of a sliver is mostly rounding)
    const auto [low, high] =
        std::minmax({dot(n, corners[0]), dot(n, corners[1]), dot(n, corners[2])});
    const double from = dot(n, sphere.from_O), to = dot(n, centre_at(t));
    const double reach = sphere.radius * kBoundSlack +
                         kRelativeSlack * (std::fabs(from) + std::fabs(to) + std::fabs(low));
    if (std::min(from, to) > high + reach || std::max(from, to) < low - reach) return;
    offset_face(corners, n);
    for (size_t i = 0; i < 3; ++i) {
      edge_cylinder(corners[i], corners[(i + 1) % 3],
                    mesh.edge_normals[mesh.triangle_edges[triangle][i]]);
      vertex_sphere(corners[i], mesh.vertex_normals[tri[i]]);
    }
  }
};

class SphereSearch {
 public:
  SphereSearch(const MeshShape& shape, const SweptSphere& sphere)
      : shape_(shape), sphere_(sphere), d_O_(sphere.to_O - sphere.from_O) {}

  void test(uint32_t triangle) {
    double t = best_.t;
    if (is_out_of_reach(triangle) || !sphere_enters_triangle(shape_.mesh, triangle, sphere_, t)) {
      return;
    }
    if (!best_.hit || t < best_.t || (t == best_.t && triangle < best_.triangle)) {
      best_ = {true, t, triangle};
    }
  }

  /// All triangles but `known`, which has been tested.
  void descend(uint32_t known) {
    WayProbe way = way_to_hit();
    const auto near = [&](const PatchNode& node) { return patches_on_way(node, way); };
    for_each_near_leaf(shape_.patches, near, [&](const PatchLeaf& leaf) {
      const double t = best_.t;
      for (LaneSet lanes = triangles_on_way(leaf, way); lanes.any(); lanes.pop()) {
        const uint32_t triangle = leaf.triangle[lanes.first()];
        if (triangle != known) test(triangle);
      }
      // what lies behind the best hit no longer matters
      if (best_.t < t) way = way_to_hit();
    });
  }

  const SegmentHit& best() const { return best_; }

 private:
  WayProbe way_to_hit() const {
    const TriangleMesh& mesh = shape_.mesh;
    const double furthest = std::max({largest_coordinate(sphere_.from_O),
                                      largest_coordinate(sphere_.to_O), largest_coordinate(mesh)});
    return {sphere_.from_O, best_.t * d_O_, sphere_.radius, furthest};
  }

  /// Whether the triangle is out of reach up to the earliest hit: separated by a plane normal to
  /// the line from the start to its closest point.
  bool is_out_of_reach(uint32_t triangle) const {
    const Vec3 u =
        sphere_.from_O - closest_on_triangle(shape_.mesh, triangle, sphere_.from_O).point;
    double gap = std::numeric_limits<double>::infinity();
    for (const uint32_t v : shape_.mesh.triangles[triangle]) {
      gap = std::min(gap, dot(u, sphere_.from_O - shape_.mesh.vertices[v]));
    }
    const double least = gap + std::min(best_.t * dot(u, d_O_), 0.0);
    return least > norm(u) * sphere_.radius * kBoundSlack;
  }

  const MeshShape& shape_;
  const SweptSphere& sphere_;
  Vec3 d_O_;
  SegmentHit best_;
};

}  // namespace

bool sphere_enters_triangle(const TriangleMesh& mesh, uint32_t triangle, const SweptSphere& sphere,
                            double& t) {
  HAPTIC_ASSERT(sphere.radius > 0 && triangle < mesh.triangles.size());
  TriangleSweep sweep{mesh, sphere, sphere.to_O - sphere.from_O, t};
  sweep.run(triangle);
  t = sweep.t;
  return sweep.hit;
}

SegmentHit first_sphere_hit(const MeshShape& shape, const SweptSphere& sphere) {
  SegmentWitness nothing_known;
  return first_sphere_hit(shape, sphere, nothing_known);
}

SegmentHit first_sphere_hit(const MeshShape& shape, const SweptSphere& sphere,
                            SegmentWitness& witness) {
  const double length = norm(sphere.to_O - sphere.from_O);
  if (shape.patches.nodes.empty() || !(length > 0) || !is_finite(sphere.to_O)) return {};
  HAPTIC_ASSERT(sphere.radius > 0);
  SphereSearch search(shape, sphere);
  const uint32_t known = witness.triangle;
  if (known < shape.mesh.triangles.size()) search.test(known);
  search.descend(known);
  witness.triangle = search.best().hit ? search.best().triangle : kNoFace;
  return search.best();
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/swept_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/query/closest_point.h"

namespace haptic {
namespace {

// a box this much too far may be so by rounding only
constexpr double kBoundSlack = kCompactSlack;
constexpr double kRelativeSlack = 1e-14;  // the same for a height, of the coordinates

/// Earliest t ≥ 0 with |m + t d| = radius, coming nearer. Written so that nothing cancels: the
/// discriminant from the point of nearest approach, the root for a centre that starts just outside.
/// False when it never does.
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

bool lies_over(const std::array<Vec3, 3>& corners, const Vec3& n, const Vec3& q) {
  for (size_t i = 0; i < 3; ++i) {
    const Vec3& a = corners[i];
    if (dot(n, cross(corners[(i + 1) % 3] - a, q - a)) < 0) return false;
  }
  return true;
}

/// One triangle and the earliest hit with it so far.
struct TriangleSweep {
  const TriangleMesh& mesh;
  const SweptSphere& sphere;
  Vec3 d_O;
  bool hit = false;
  double t = 1;

  void take(double at) {
    if (at > t) return;
    hit = true;
    t = at;
  }
  Vec3 centre_at(double at) const { return sphere.from_O + at * d_O; }

  void offset_face(const std::array<Vec3, 3>& corners, const Vec3& n) {
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
    const double start = dot(m, along) / length2, speed = dot(d_O, along) / length2;
    double at = 0;
    if (!enters_ball(m - start * along, d_O - speed * along, sphere.radius, at) || at > t) return;
    const double where = start + at * speed;
    if (where < 0 || where > 1) return;
    if (dot(centre_at(at) - (a + where * along), front_O) >= 0) take(at);
  }

  void vertex_sphere(const Vec3& a, const Vec3& front_O) {
    double at = 0;
    if (!enters_ball(sphere.from_O - a, d_O, sphere.radius, at) || at > t) return;
    if (dot(centre_at(at) - a, front_O) >= 0) take(at);
  }

  void run(uint32_t triangle) {
    const Triangle& tri = mesh.triangles[triangle];
    const std::array<Vec3, 3> corners{mesh.vertices[tri[0]], mesh.vertices[tri[1]],
                                      mesh.vertices[tri[2]]};
    const Vec3& n = mesh.face_normals[triangle];
    // most triangles: the sphere stays on one side of all corners (a sliver's normal is rounding)
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

/// Lower bound of the squared distance from p_O to everything in the box.
double distance_squared(const Obb& box, const Vec3& p_O) {
  const Vec3 q = box.R_BO * (p_O - box.centre_O);
  const double x = std::max(std::fabs(q.x) - box.half.x, 0.0);
  const double y = std::max(std::fabs(q.y) - box.half.y, 0.0);
  const double z = std::max(std::fabs(q.z) - box.half.z, 0.0);
  return x * x + y * y + z * z;
}

/// Whether the sphere on its way middle ± half may meet the box: the box grown by the radius, three
/// axes, then the ball around the whole way.
bool may_meet_box(const Obb& box, const Vec3& middle_O, const Vec3& half_O, double radius) {
  const Vec3 m = box.R_BO * (middle_O - box.centre_O);
  const Vec3 w = box.R_BO * half_O;
  const Vec3 beyond{std::fabs(m.x) - box.half.x, std::fabs(m.y) - box.half.y,
                    std::fabs(m.z) - box.half.z};
  if (beyond.x > (std::fabs(w.x) + radius) * kBoundSlack) return false;
  if (beyond.y > (std::fabs(w.y) + radius) * kBoundSlack) return false;
  if (beyond.z > (std::fabs(w.z) + radius) * kBoundSlack) return false;
  const double ball = (radius + norm(half_O)) * kBoundSlack;
  const Vec3 outside{std::max(beyond.x, 0.0), std::max(beyond.y, 0.0), std::max(beyond.z, 0.0)};
  return norm_squared(outside) <= ball * ball;
}

struct Waiting {
  double bound;  // squared distance from the start
  uint32_t node;
};

void visit_leaf(const MeshShape& shape, const ObbNode& leaf, const SweptSphere& sphere,
                SegmentHit& best) {
  for (const uint32_t triangle : shape.tree.order.subspan(leaf.first, leaf.count)) {
    double t = best.t;
    if (!sphere_enters_triangle(shape.mesh, triangle, sphere, t)) continue;
    if (!best.hit || t < best.t || (t == best.t && triangle < best.triangle)) {
      best = {true, t, triangle};
    }
  }
}

}  // namespace

bool sphere_enters_triangle(const TriangleMesh& mesh, uint32_t triangle, const SweptSphere& sphere,
                            double& t) {
  TriangleSweep sweep{mesh, sphere, sphere.to_O - sphere.from_O, false, t};
  sweep.run(triangle);
  t = sweep.t;
  return sweep.hit;
}

SegmentHit first_sphere_hit(const MeshShape& shape, const SweptSphere& sphere) {
  SegmentHit best;
  const Vec3 d_O = sphere.to_O - sphere.from_O;
  const double length = norm(d_O);
  if (shape.tree.nodes.empty() || !(length > 0) || !is_finite(sphere.to_O)) return best;
  // one sibling waits per level
  std::array<Waiting, kMaxTreeDepth + 1> stack;
  size_t waiting = 0;
  stack[waiting++] = {distance_squared(shape.tree.nodes[0].box.unpacked(), sphere.from_O), 0};
  while (waiting > 0) {
    const auto [bound, index] = stack[--waiting];
    // what the sphere cannot reach before the best hit is of no interest
    const double reach = (sphere.radius + best.t * length) * kBoundSlack;
    if (bound > reach * reach) continue;
    const ObbNode& node = shape.tree.nodes[index];
    const Vec3 half_O = (0.5 * best.t) * d_O;
    if (!may_meet_box(node.box.unpacked(), sphere.from_O + half_O, half_O, sphere.radius)) continue;
    if (node.count > 0) {
      visit_leaf(shape, node, sphere, best);
      continue;
    }
    const auto wait_for = [&](uint32_t child) {
      return Waiting{distance_squared(shape.tree.nodes[child].box.unpacked(), sphere.from_O),
                     child};
    };
    Waiting near = wait_for(node.first), far = wait_for(node.first + 1u);
    if (far.bound < near.bound) std::swap(near, far);
    stack[waiting++] = far;
    stack[waiting++] = near;
  }
  return best;
}

}  // namespace haptic

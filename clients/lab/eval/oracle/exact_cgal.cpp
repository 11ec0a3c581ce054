// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/exact_cgal.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <vector>

namespace haptic {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 point(const Vec3& p) {
  return {p.x, p.y, p.z};
}

struct Box {
  Vec3 lower, upper;

  explicit Box(const Vec3& p) : lower(p), upper(p) {}
  void add(const Vec3& p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  bool overlaps(const Box& b) const {
    return lower.x <= b.upper.x && b.lower.x <= upper.x && lower.y <= b.upper.y &&
           b.lower.y <= upper.y && lower.z <= b.upper.z && b.lower.z <= upper.z;
  }
};

Box box_of(const std::array<Vec3, 3>& corners) {
  Box box(corners[0]);
  box.add(corners[1]);
  box.add(corners[2]);
  return box;
}

Kernel::Triangle_3 to_cgal(const std::array<Vec3, 3>& t) {
  return {point(t[0]), point(t[1]), point(t[2])};
}

}  // namespace

bool surfaces_meet_by_cgal(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT) {
  std::vector<Vec3> vertices_O;
  for (const Vec3& v : tool.vertices) vertices_O.push_back(X_OT * v);
  Box all(vertices_O.at(0));
  for (const Vec3& v : vertices_O) all.add(v);
  for (const Triangle& a : object.triangles) {
    const std::array corners_a{object.vertices[a[0]], object.vertices[a[1]], object.vertices[a[2]]};
    const Box box_a = box_of(corners_a);
    if (!box_a.overlaps(all)) continue;
    const Kernel::Triangle_3 triangle_a = to_cgal(corners_a);
    for (const Triangle& b : tool.triangles) {
      const std::array corners_b{vertices_O[b[0]], vertices_O[b[1]], vertices_O[b[2]]};
      if (!box_a.overlaps(box_of(corners_b))) continue;
      if (CGAL::do_intersect(triangle_a, to_cgal(corners_b))) return true;
    }
  }
  return false;
}

}  // namespace haptic

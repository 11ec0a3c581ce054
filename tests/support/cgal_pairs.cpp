// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/cgal_pairs.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>

namespace haptic::test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<std::array<Vec3, 3>>;
using Iterator = Triangles::const_iterator;
using Box = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, Iterator>;

Kernel::Triangle_3 to_cgal(const std::array<Vec3, 3>& t) {
  const auto point = [](const Vec3& p) { return Kernel::Point_3(p.x, p.y, p.z); };
  return {point(t[0]), point(t[1]), point(t[2])};
}

std::vector<Box> boxes_of(const Triangles& triangles) {
  std::vector<Box> boxes;
  for (Iterator it = triangles.begin(); it != triangles.end(); ++it) {
    boxes.emplace_back(to_cgal(*it).bbox(), it);
  }
  return boxes;
}

}  // namespace

bool cgal_triangles_meet(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  return CGAL::do_intersect(to_cgal(a), to_cgal(b));
}

std::vector<std::pair<uint32_t, uint32_t>> cgal_triangle_pairs(const Triangles& a,
                                                               const Triangles& b) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  std::vector<Box> boxes_a = boxes_of(a), boxes_b = boxes_of(b);
  CGAL::box_intersection_d(boxes_a.begin(), boxes_a.end(), boxes_b.begin(), boxes_b.end(),
                           [&](const Box& box_a, const Box& box_b) {
                             if (!cgal_triangles_meet(*box_a.handle(), *box_b.handle())) return;
                             pairs.emplace_back(static_cast<uint32_t>(box_a.handle() - a.begin()),
                                                static_cast<uint32_t>(box_b.handle() - b.begin()));
                           });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace haptic::test

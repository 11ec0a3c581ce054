// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>

#include <span>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// The triangles of a mesh in CGAL's tree of bounding boxes.
template <class Kernel>
struct CgalTriangles {
  using Triangles = std::vector<typename Kernel::Triangle_3>;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<
      Kernel, CGAL::AABB_triangle_primitive<Kernel, typename Triangles::iterator>>>;

  CgalTriangles(std::span<const Vec3> vertices, std::span<const Triangle> corners) {
    const auto point = [&](uint32_t i) {
      return typename Kernel::Point_3(vertices[i].x, vertices[i].y, vertices[i].z);
    };
    triangles.reserve(corners.size());
    for (const auto& [a, b, c] : corners) triangles.emplace_back(point(a), point(b), point(c));
    tree.rebuild(triangles.begin(), triangles.end());
  }

  Triangles triangles;
  Tree tree;
};

}  // namespace haptic

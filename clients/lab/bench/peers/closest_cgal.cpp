// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include "clients/lab/bench/peers/closest.h"

namespace haptic {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Tree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::iterator>>>;

struct Searcher {
  explicit Searcher(const TriangleMesh& mesh) {
    const auto point = [&](uint32_t v) {
      return Point(mesh.vertices[v].x, mesh.vertices[v].y, mesh.vertices[v].z);
    };
    for (const auto& [a, b, c] : mesh.triangles) {
      triangles.emplace_back(point(a), point(b), point(c));
    }
    tree.rebuild(triangles.begin(), triangles.end());
    tree.accelerate_distance_queries();
    previous = triangles.at(0)[0];
  }
  Triangles triangles;
  Tree tree;
  Point previous;
};

}  // namespace

std::vector<ClosestPeer> cgal_peers(const TriangleMesh& mesh) {
  const auto searcher = std::make_shared<Searcher>(mesh);
  const auto own_hint = [searcher](const Vec3& p) {
    const Point q(p.x, p.y, p.z);
    return std::sqrt(CGAL::squared_distance(q, searcher->tree.closest_point(q)));
  };
  const auto previous_hint = [searcher](const Vec3& p) {
    const Point q(p.x, p.y, p.z);
    searcher->previous = searcher->tree.closest_point(q, searcher->previous);
    return std::sqrt(CGAL::squared_distance(q, searcher->previous));
  };
  return {{"CGAL AABB tree", own_hint}, {"CGAL AABB tree, previous point", previous_hint}};
}

}  // namespace haptic

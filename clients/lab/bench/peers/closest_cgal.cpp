// SPDX-License-Identifier: GPL-3.0-or-later
#include <CGAL/Simple_cartesian.h>

#include "clients/lab/bench/peers/closest.h"
#include "clients/lab/support/triangles_cgal.h"

namespace haptic {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;

struct Searcher : CgalTriangles<Kernel> {
  explicit Searcher(const TriangleMesh& mesh)
      : CgalTriangles(mesh.vertices, mesh.triangles), previous(triangles.at(0)[0]) {
    tree.accelerate_distance_queries();
  }
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

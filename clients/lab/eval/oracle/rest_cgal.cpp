// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/rest_cgal.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clients/lab/support/dice.h"

namespace haptic {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Primitive = CGAL::AABB_face_graph_triangle_primitive<Mesh>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
using Side = CGAL::Side_of_triangle_mesh<Mesh, Kernel>;

constexpr std::array kLengths{1e-5, 1e-4, 3e-4, 1e-3, 3e-3};  // of the tried segments [m]
constexpr double kFirst = 1e-9;  // skipped at the start of a segment: 10⁷ roundings at 0.1 m [m]

Kernel::Point_3 to_cgal_rest(const Vec3& p) {
  return {p.x, p.y, p.z};
}

Mesh to_cgal_rest(const TriangleMesh& mesh) {
  Mesh out;
  std::vector<Mesh::Vertex_index> vertices;
  for (const Vec3& v : mesh.vertices) vertices.push_back(out.add_vertex(to_cgal_rest(v)));
  for (const auto& [a, b, c] : mesh.triangles) out.add_face(vertices[a], vertices[b], vertices[c]);
  return out;
}

}  // namespace

struct WayJudge::Tree {
  explicit Tree(const TriangleMesh& triangles)
      : mesh(to_cgal_rest(triangles)),
        tree(faces(mesh).begin(), faces(mesh).end(), mesh),
        side(tree) {}

  Mesh mesh;
  AabbTree tree;
  Side side;
};

WayJudge::WayJudge(const TriangleMesh& mesh) : tree_(std::make_unique<Tree>(mesh)) {}

WayJudge::~WayJudge() = default;

bool WayJudge::holds(const Vec3& p_O) const {
  return tree_->side(to_cgal_rest(p_O)) != CGAL::ON_UNBOUNDED_SIDE;
}

bool WayJudge::is_free(const Vec3& from_O, const Vec3& to_O) const {
  return !tree_->tree.do_intersect(Kernel::Segment_3(to_cgal_rest(from_O), to_cgal_rest(to_O))) &&
         !holds(from_O);
}

std::optional<double> WayJudge::free_way(const Vec3& proxy_O, const Vec3& tool_O, double least,
                                         int directions, uint64_t seed) const {
  Dice dice(seed);
  const Vec3 way_O = tool_O - proxy_O;
  const double far = norm(way_O);
  std::optional<double> best;
  for (int i = 0; i < directions; ++i) {
    Vec3 d_O = dice.direction();
    if (dot(d_O, way_O) < 0) d_O = -1.0 * d_O;
    for (const double length : kLengths) {
      // beyond the foot of the perpendicular from the tool, the distance grows again
      const double s = std::min(length, dot(d_O, way_O));
      const Vec3 end_O = proxy_O + s * d_O;
      if (s <= kFirst || !is_free(proxy_O + kFirst * d_O, end_O)) break;
      const double gain = far - norm(tool_O - end_O);
      if (gain > best.value_or(least)) best = gain;
      if (s < length) break;
    }
  }
  return best;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/cgal_pairs.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Gmpzf.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polytope_distance_d.h>
#include <CGAL/Polytope_distance_d_traits_3.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cmath>
#include <sstream>

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

CgalSurface cgal_surface(std::span<const Vec3> vertices,
                         std::span<const std::array<uint32_t, 3>> triangles) {
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  namespace pmp = CGAL::Polygon_mesh_processing;
  Mesh mesh;
  for (const Vec3& v : vertices) mesh.add_vertex({v.x, v.y, v.z});
  CgalSurface surface{.is_manifold = true};
  for (const auto& [a, b, c] : triangles) {
    const auto face =
        mesh.add_face(Mesh::Vertex_index(a), Mesh::Vertex_index(b), Mesh::Vertex_index(c));
    if (face == Mesh::null_face()) surface.is_manifold = false;
  }
  surface.is_manifold = surface.is_manifold && mesh.is_valid();
  surface.is_closed = surface.is_manifold && CGAL::is_closed(mesh);
  surface.faces_out = surface.is_closed && pmp::is_outward_oriented(mesh);
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
  pmp::self_intersections(mesh, std::back_inserter(pairs));
  surface.self_intersections = pairs.size();
  return surface;
}

double cgal_polytope_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  using Plain = CGAL::Simple_cartesian<double>;
  using Traits = CGAL::Polytope_distance_d_traits_3<Plain, CGAL::Gmpzf, double>;
  std::vector<Plain::Point_3> p, q;
  for (const Vec3& v : a) p.emplace_back(v.x, v.y, v.z);
  for (const Vec3& v : b) q.emplace_back(v.x, v.y, v.z);
  const CGAL::Polytope_distance_d<Traits> found(p.begin(), p.end(), q.begin(), q.end());
  return std::sqrt(CGAL::to_double(found.squared_distance_numerator()) /
                   CGAL::to_double(found.squared_distance_denominator()));
}

CgalPly cgal_read_ply(const std::string& bytes) {
  std::istringstream in(bytes);
  CGAL::IO::set_binary_mode(in);
  std::vector<Kernel::Point_3> points;
  std::vector<CGAL::IO::Color> point_colours, polygon_colours;
  CgalPly ply;
  ply.is_read = CGAL::IO::read_PLY(in, points, ply.polygons, polygon_colours, point_colours);
  for (const auto& p : points) ply.points.push_back({p.x(), p.y(), p.z()});
  const auto copy = [](const std::vector<CGAL::IO::Color>& from, auto& to) {
    for (const CGAL::IO::Color& c : from) to.push_back({c.red(), c.green(), c.blue()});
  };
  copy(point_colours, ply.point_colours);
  copy(polygon_colours, ply.polygon_colours);
  return ply;
}

}  // namespace haptic::test

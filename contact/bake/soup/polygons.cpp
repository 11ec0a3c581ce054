// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/soup/polygons.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "contact/bake/soup/report.h"

namespace haptic {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point2 = Kernel::Point_2;
using Point3 = Kernel::Point_3;
using Vertices = CGAL::Triangulation_vertex_base_with_info_2<uint32_t, Kernel>;  // the corner
using Faces = CGAL::Triangulation_face_base_with_info_2<
    bool, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;  // whether it is outside
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<Vertices, Faces>>;

/// Corners of a polygon in canonical order: from the lexicographically first one towards the
/// smaller of its neighbours.
std::vector<uint32_t> in_order(std::span<const Vec3> corners) {
  const auto place = [&](size_t i) {
    const Vec3& p = corners[i % corners.size()];
    return std::tuple(p.x, p.y, p.z);
  };
  const size_t n = corners.size();
  size_t first = 0;
  for (size_t i = 1; i < n; ++i) first = place(i) < place(first) ? i : first;
  const size_t step = place(first + 1) < place(first + n - 1) ? 1 : n - 1;
  std::vector<uint32_t> order(n);
  for (size_t i = 0; i < n; ++i) order[i] = static_cast<uint32_t>((first + i * step) % n);
  return order;
}

/// The axis of the largest component of the area vector of the corners in that order (Newell's
/// normal). Scaled by their extent, so that no product overflows.
int axis_of_projection(std::span<const Vec3> corners, const std::vector<uint32_t>& order) {
  const Vec3& origin = corners[order[0]];
  double extent = 0;
  for (const Vec3& p : corners) {
    for (int k = 0; k < 3; ++k) extent = std::max(extent, std::fabs(p[k] / 2 - origin[k] / 2));
  }
  const auto from_origin = [&](uint32_t i) {
    Vec3 d;
    for (int k = 0; k < 3; ++k) d[k] = (corners[i][k] / 2 - origin[k] / 2) / extent;
    return d;
  };
  Vec3 normal;
  for (size_t i = 2; i < order.size(); ++i) {
    normal += cross(from_origin(order[i - 1]), from_origin(order[i]));
  }
  int axis = 0;
  for (const int k : {1, 2}) axis = std::fabs(normal[k]) > std::fabs(normal[axis]) ? k : axis;
  return axis;
}

/// A polygon projected along an axis, in canonical order.
struct Projection {
  std::vector<uint32_t> order;  // indices of the corners
  std::vector<Point2> points;
};

/// The outline projected along one axis; empty if it touches or crosses itself.
std::optional<Projection> simple_projection(std::span<const Vec3> corners) {
  const std::vector<uint32_t> order = in_order(corners);
  const int axis = axis_of_projection(corners, order);
  std::vector<Point2> flat;
  flat.reserve(order.size());
  for (const uint32_t i : order) {
    flat.emplace_back(corners[i][(axis + 1) % 3], corners[i][(axis + 2) % 3]);
  }
  if (!CGAL::is_simple_2(flat.begin(), flat.end())) return std::nullopt;
  return Projection{order, flat};
}

bool is_on_one_line(std::span<const Vec3> corners) {
  const auto point = [&](size_t i) { return Point3(corners[i].x, corners[i].y, corners[i].z); };
  const Point3 first = point(0);
  size_t other = 1;
  while (other < corners.size() && point(other) == first) ++other;
  for (size_t i = other + 1; i < corners.size(); ++i) {
    if (!CGAL::collinear(first, point(other), point(i))) return false;
  }
  return true;
}

/// Marks the faces that can be reached from infinity without crossing the polygon.
void mark_outside(Triangulation& triangulation) {
  for (const auto face : triangulation.all_face_handles()) face->info() = false;
  std::vector<Triangulation::Face_handle> seen{triangulation.infinite_face()};
  seen.back()->info() = true;
  while (!seen.empty()) {
    const Triangulation::Face_handle face = seen.back();
    seen.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Triangulation::Face_handle next = face->neighbor(i);
      if (face->is_constrained(i) || next->info()) continue;
      next->info() = true;
      seen.push_back(next);
    }
  }
}

/// Triangles of indices into the polygon, counter-clockwise in its plane.
std::vector<Triangle> triangulate(const std::vector<Point2>& polygon) {
  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> vertices;
  for (uint32_t i = 0; i < polygon.size(); ++i) {
    vertices.push_back(triangulation.insert(
        polygon[i], i > 0 ? vertices.back()->face() : Triangulation::Face_handle()));
    vertices.back()->info() = i;
  }
  for (size_t i = 0; i < vertices.size(); ++i) {
    triangulation.insert_constraint(vertices[i], vertices[(i + 1) % vertices.size()]);
  }
  mark_outside(triangulation);
  std::vector<Triangle> triangles;
  for (const auto face : triangulation.finite_face_handles()) {
    if (face->info()) continue;
    triangles.push_back(
        {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  }
  return triangles;
}

std::vector<Triangle> fan(size_t corners) {
  std::vector<Triangle> triangles;
  for (uint32_t i = 2; i < corners; ++i) triangles.push_back({0, i - 1, i});
  return triangles;
}

/// The corners of a polygon, without consecutive duplicates.
std::vector<Vec3> distinct_corners(const PolygonSoup& soup, const std::vector<size_t>& polygon) {
  std::vector<Vec3> corners;
  for (const size_t i : polygon) {
    if (corners.empty() || soup.points[i] != corners.back()) corners.push_back(soup.points[i]);
  }
  while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
  return corners;
}

}  // namespace

std::optional<std::vector<Triangle>> cut_polygon(std::span<const Vec3> corners) {
  if (corners.size() <= 3 || is_on_one_line(corners)) return fan(corners.size());
  const auto projection = simple_projection(corners);
  if (!projection) return std::nullopt;
  const auto& [order, flat] = *projection;
  std::vector<Triangle> triangles = triangulate(flat);
  // order runs with the corners or against them, and turns left or right in the plane
  const bool is_with = order[1] == (order[0] + 1) % order.size();
  const bool is_left = CGAL::orientation_2(flat.begin(), flat.end()) == CGAL::COUNTERCLOCKWISE;
  for (Triangle& triangle : triangles) {
    for (uint32_t& i : triangle) i = order[i];
    if (is_with != is_left) std::swap(triangle[1], triangle[2]);
  }
  return triangles;
}

void check_polygons(const PolygonSoup& soup, const std::string& name) {
  for (size_t f = 0; f < soup.polygons.size(); ++f) {
    if (soup.polygons[f].size() <= 3) continue;
    const std::vector<Vec3> corners = distinct_corners(soup, soup.polygons[f]);
    if (corners.size() <= 3 || is_on_one_line(corners) || simple_projection(corners)) continue;
    throw MeshError(name + ": face " + std::to_string(f + 1) + ", of " +
                    std::to_string(soup.polygons[f].size()) +
                    " corners, touches or crosses itself and cannot be cut into triangles; "
                    "triangulate on export");
  }
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/hull_of_points.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "contact/shape/mesh/box.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Trio = std::array<uint32_t, 3>;  // of points or of triangles

// in shares of the longest extent of the points
constexpr double kFlat = 1e-8;   // of a face; the normal of a sliver as high is good to 1e-8
constexpr double kThin = 1e-7;   // of a body whose sides would be slivers
constexpr double kLine = 1e-14;  // height of a triangle that has no plane: rounding alone
constexpr uint32_t kNone = ~0u;

double extent_of_points(std::span<const Vec3> points) {
  for (const Vec3& p : points) {
    if (!is_finite(p)) throw InputError("convex hull: a point is not finite; repair the mesh");
  }
  return longest_of(box_around(points).size());
}

template <class Measure>
const Vec3& farthest(std::span<const Vec3> points, const Measure& measure) {
  return *std::max_element(points.begin(), points.end(),
                           [&](const Vec3& a, const Vec3& b) { return measure(a) < measure(b); });
}

/// Unit normal of a wide triangle of the points.
Vec3 wide_normal(std::span<const Vec3> points, double extent) {
  const Vec3 a = points[0];
  const Vec3 b = farthest(points, [&](const Vec3& p) { return norm_squared(p - a); });
  const Vec3 way = b - a;
  const Vec3 c = farthest(points, [&](const Vec3& p) { return norm_squared(cross(way, p - a)); });
  const Vec3 normal = cross(way, c - a);
  if (!(norm(normal) > kLine * extent * norm(way))) {
    throw InputError("convex hull: the points lie on a line; remove triangles without area");
  }
  return normalized(normal);
}

/// Faces as cycles of points, to half-edges.
std::optional<PointsHull> joined(std::span<const Vec3> points,
                                 const std::vector<std::vector<uint32_t>>& cycles) {
  PointsHull out;
  HullData& hull = out.hull;
  std::map<uint32_t, uint32_t> vertex_of;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> edge_of;
  for (const std::vector<uint32_t>& cycle : cycles) {
    const auto n = static_cast<uint32_t>(cycle.size());
    const auto first = static_cast<uint32_t>(hull.edges.size());
    const auto face = static_cast<uint32_t>(hull.faces.size());
    Vec3 normal;
    for (uint32_t k = 0; k < n; ++k) {
      const uint32_t point = cycle[k];
      const auto next_vertex = static_cast<uint32_t>(hull.vertices.size());
      const auto [at, is_new] = vertex_of.try_emplace(point, next_vertex);
      if (is_new) {
        hull.vertices.push_back(points[point]);
        hull.edge_from.push_back(first + k);
        out.point_of.push_back(point);
      }
      if (!edge_of.try_emplace({point, cycle[(k + 1) % n]}, first + k).second) return {};
      hull.edges.push_back({at->second, kNone, first + (k + 1) % n, face});
      normal += cross(points[point] - points[cycle[0]], points[cycle[(k + 1) % n]] - points[point]);
    }
    normal = normalized(normal);
    double offset = dot(normal, points[cycle[0]]);
    for (const uint32_t point : cycle) offset = std::max(offset, dot(normal, points[point]));
    hull.faces.push_back({normal, offset, first, n, 0, kNoTriangle});
  }
  for (const auto& [ends, edge] : edge_of) {
    const auto twin = edge_of.find({ends.second, ends.first});
    if (twin == edge_of.end()) return {};
    hull.edges[edge].twin = twin->second;
  }
  return out;
}

PointsHull two_sided(std::span<const Vec3> points, const Vec3& normal) {
  // along the axis nearest to the normal the projection keeps the coordinates
  const int drop = longest_axis({std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)});
  const int u = (drop + 1) % 3, v = (drop + 2) % 3;
  std::vector<Kernel::Point_2> flat, corners;
  std::map<std::pair<double, double>, uint32_t> point_at;
  for (uint32_t i = 0; i < points.size(); ++i) {
    flat.emplace_back(points[i][u], points[i][v]);
    point_at.try_emplace({points[i][u], points[i][v]}, i);
  }
  CGAL::convex_hull_2(flat.begin(), flat.end(), std::back_inserter(corners));
  std::vector<uint32_t> cycle;
  for (const auto& p : corners) cycle.push_back(point_at.at({p.x(), p.y()}));
  const std::vector<uint32_t> back(cycle.rbegin(), cycle.rend());
  if (cycle.size() < 3) throw InputError("convex hull: the points lie on a line; remove them");
  return *joined(points, {cycle, back});
}

/// The triangles of the hull, as points.
std::vector<Trio> hull_triangles(std::span<const Vec3> points) {
  std::vector<Kernel::Point_3> input;
  std::map<std::tuple<double, double, double>, uint32_t> point_at;
  for (uint32_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i];
    if (point_at.try_emplace({p.x, p.y, p.z}, i).second) input.emplace_back(p.x, p.y, p.z);
  }
  SurfaceMesh mesh;
  CGAL::convex_hull_3(input.begin(), input.end(), mesh);
  std::vector<Trio> triangles;
  for (const auto face : mesh.faces()) {
    Trio& corners = triangles.emplace_back();
    size_t k = 0;
    for (const auto vertex : mesh.vertices_around_face(mesh.halfedge(face))) {
      const auto& p = mesh.point(vertex);
      corners[k++] = point_at.at({p.x(), p.y(), p.z()});
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  }
  // CGAL's order depends on addresses
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Which triangle is beyond each edge.
std::vector<Trio> neighbours_of(const std::vector<Trio>& triangles) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> triangle_at;
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    for (size_t k = 0; k < 3; ++k) triangle_at[{triangles[t][k], triangles[t][(k + 1) % 3]}] = t;
  }
  std::vector<Trio> neighbours(triangles.size());
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    for (size_t k = 0; k < 3; ++k) {
      neighbours[t][k] = triangle_at.at({triangles[t][(k + 1) % 3], triangles[t][k]});
    }
  }
  return neighbours;
}

/// A number of its polygon for each triangle: from the largest on, with all around it that lie in
/// its plane and face the same way, so that slivers join what they lie in.
std::vector<uint32_t> hull_polygons(std::span<const Vec3> points,
                                    const std::vector<Trio>& triangles,
                                    const std::vector<Trio>& neighbours, double tolerance) {
  std::vector<Vec3> normals;
  for (const auto& [a, b, c] : triangles) {
    normals.push_back(cross(points[b] - points[a], points[c] - points[a]));
  }
  std::vector<uint32_t> order(triangles.size()), polygon(triangles.size(), kNone), waiting;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return norm_squared(normals[a]) > norm_squared(normals[b]);
  });
  uint32_t n_polygons = 0;
  for (const uint32_t seed : order) {
    if (polygon[seed] != kNone) continue;
    const Vec3 normal = normalized(normals[seed]), origin = points[triangles[seed][0]];
    const auto joins = [&](uint32_t t) {
      return polygon[t] == kNone && dot(normals[t], normal) >= 0 &&
             std::all_of(triangles[t].begin(), triangles[t].end(), [&](uint32_t p) {
               return std::fabs(dot(normal, points[p] - origin)) <= tolerance;
             });
    };
    polygon[seed] = n_polygons;
    waiting.assign(1, seed);
    while (!waiting.empty()) {
      const uint32_t t = waiting.back();
      waiting.pop_back();
      for (const uint32_t next : neighbours[t]) {
        if (joins(next)) polygon[next] = n_polygons, waiting.push_back(next);
      }
    }
    ++n_polygons;
  }
  return polygon;
}

/// The polygons of the triangles with these numbers; nothing where one is not a simple polygon with
/// three corners that three polygons share.
std::optional<PointsHull> merged(std::span<const Vec3> points, const std::vector<Trio>& triangles,
                                 const std::vector<Trio>& neighbours,
                                 const std::vector<uint32_t>& polygon) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> end_of;  // of (polygon, start of a border)
  std::map<uint32_t, uint32_t> n_borders;                    // that leave a point
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (size_t k = 0; k < 3; ++k) {
      if (polygon[neighbours[t][k]] == polygon[t]) continue;
      const uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
      if (!end_of.try_emplace({polygon[t], from}, to).second) return {};
      ++n_borders[from];
    }
  }
  const size_t n_ends = end_of.size();
  size_t n_walked = 0;
  std::vector<std::vector<uint32_t>> cycles;
  for (auto at = end_of.begin(); at != end_of.end();) {
    const auto [number, first] = at->first;
    std::vector<uint32_t> cycle;
    uint32_t point = first;
    do {
      if (n_borders[point] > 2) cycle.push_back(point);
      if (++n_walked > n_ends) return {};
      point = end_of.at({number, point});
    } while (point != first);
    if (cycle.size() < 3) return {};
    cycles.push_back(std::move(cycle));
    while (at != end_of.end() && at->first.first == number) ++at;
  }
  if (n_walked != n_ends) return {};  // a polygon with a hole
  std::optional<PointsHull> hull = joined(points, cycles);
  if (!hull) return {};
  const HullData& h = hull->hull;
  if (h.vertices.size() + h.faces.size() != h.edges.size() / 2 + 2) return {};
  return hull;
}

}  // namespace

PointsHull hull_of_points(std::span<const Vec3> points) {
  if (points.size() < 3) throw InputError("convex hull: three points are needed; give more");
  const double extent = extent_of_points(points);
  const Vec3 normal = wide_normal(points, extent);
  const auto along = [&](const Vec3& p) { return dot(normal, p - points[0]); };
  const auto [low, high] =
      std::minmax_element(points.begin(), points.end(),
                          [&](const Vec3& a, const Vec3& b) { return along(a) < along(b); });
  if (along(*high) - along(*low) <= kThin * extent) return two_sided(points, normal);

  const std::vector<Trio> triangles = hull_triangles(points);
  const std::vector<Trio> neighbours = neighbours_of(triangles);
  auto hull = merged(points, triangles, neighbours,
                     hull_polygons(points, triangles, neighbours, kFlat * extent));
  if (hull) return std::move(*hull);
  // a shape at the limit of the tolerance: its triangles as they are
  std::vector<uint32_t> alone(triangles.size());
  std::iota(alone.begin(), alone.end(), 0);
  hull = merged(points, triangles, neighbours, alone);
  if (!hull) throw InputError("convex hull: the surface is not one of a body; repair the mesh");
  return std::move(*hull);
}

}  // namespace haptic

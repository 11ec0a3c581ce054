// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/hull_of_points.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_2.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <cmath>
#include <functional>
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
  const Vec3 size{std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)};
  const int drop = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
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

/// The triangles of CGAL's hull, as points. Of points in one plane it may take any triangles, and
/// in any order: both depend on addresses.
std::vector<Trio> some_triangles(std::span<const Vec3> points) {
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
  }
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

/// A number of its patch for each triangle: each seed, in this order, with all around it for which
/// joins(seed, triangle).
template <class Joins>
std::vector<uint32_t> patches_of(const std::vector<Trio>& neighbours,
                                 const std::vector<uint32_t>& seeds, const Joins& joins) {
  std::vector<uint32_t> patch(neighbours.size(), kNone), waiting;
  uint32_t n_patches = 0;
  for (const uint32_t seed : seeds) {
    if (patch[seed] != kNone) continue;
    patch[seed] = n_patches;
    for (waiting.assign(1, seed); !waiting.empty();) {
      const uint32_t t = waiting.back();
      waiting.pop_back();
      for (const uint32_t next : neighbours[t]) {
        if (patch[next] == kNone && joins(seed, next)) {
          patch[next] = n_patches, waiting.push_back(next);
        }
      }
    }
    ++n_patches;
  }
  return patch;
}

std::vector<uint32_t> numbers_to(size_t n) {
  std::vector<uint32_t> numbers(n);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

using Cycles = std::vector<std::vector<uint32_t>>;

/// The borders of the patches, of the points that three of them share; nothing where one is not a
/// simple polygon with three such corners.
std::optional<Cycles> borders_of(const std::vector<Trio>& triangles,
                                 const std::vector<Trio>& neighbours,
                                 const std::vector<uint32_t>& patch) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> end_of;  // of (patch, start of a border)
  std::map<uint32_t, uint32_t> n_borders;                    // that leave a point
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (size_t k = 0; k < 3; ++k) {
      if (patch[neighbours[t][k]] == patch[t]) continue;
      const uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
      if (!end_of.try_emplace({patch[t], from}, to).second) return {};
      ++n_borders[from];
    }
  }
  const size_t n_ends = end_of.size();
  size_t n_walked = 0;
  Cycles cycles;
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
  if (n_walked != n_ends) return {};  // a patch with a hole
  return cycles;
}

/// The triangles of the hull, as points, whatever CGAL has taken: each facet, exactly in one plane,
/// is a fan from its lowest corner.
std::vector<Trio> hull_triangles(std::span<const Vec3> points) {
  const std::vector<Trio> any = some_triangles(points), neighbours = neighbours_of(any);
  const auto exact = [&](uint32_t p) {
    return Kernel::Point_3(points[p].x, points[p].y, points[p].z);
  };
  const auto is_coplanar = [&](uint32_t seed, uint32_t t) {
    const auto& [a, b, c] = any[seed];
    return std::ranges::all_of(
        any[t], [&](uint32_t p) { return CGAL::coplanar(exact(a), exact(b), exact(c), exact(p)); });
  };
  const auto facets =
      borders_of(any, neighbours, patches_of(neighbours, numbers_to(any.size()), is_coplanar));
  if (!facets) throw InputError("convex hull: the surface is not one of a body; repair the mesh");
  std::vector<Trio> triangles;
  for (std::vector<uint32_t> facet : *facets) {
    std::ranges::rotate(facet, std::ranges::min_element(facet));
    for (size_t k = 1; k + 1 < facet.size(); ++k) {
      triangles.push_back({facet[0], facet[k], facet[k + 1]});
    }
  }
  std::ranges::sort(triangles);
  return triangles;
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
  std::vector<uint32_t> order = numbers_to(triangles.size());
  std::ranges::stable_sort(order, std::greater{},
                           [&](uint32_t t) { return norm_squared(normals[t]); });
  return patches_of(neighbours, order, [&](uint32_t seed, uint32_t t) {
    const Vec3 normal = normalized(normals[seed]), origin = points[triangles[seed][0]];
    return dot(normals[t], normal) >= 0 && std::ranges::all_of(triangles[t], [&](uint32_t p) {
             return std::fabs(dot(normal, points[p] - origin)) <= tolerance;
           });
  });
}

/// The body whose faces are the patches; nothing where they are those of no body.
std::optional<PointsHull> merged(std::span<const Vec3> points, const std::vector<Trio>& triangles,
                                 const std::vector<Trio>& neighbours,
                                 const std::vector<uint32_t>& patch) {
  const std::optional<Cycles> cycles = borders_of(triangles, neighbours, patch);
  std::optional<PointsHull> hull = cycles ? joined(points, *cycles) : std::nullopt;
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
  hull = merged(points, triangles, neighbours, numbers_to(triangles.size()));
  if (!hull) throw InputError("convex hull: the surface is not one of a body; repair the mesh");
  return std::move(*hull);
}

}  // namespace haptic

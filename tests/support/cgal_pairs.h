// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/math/vec3.h"

namespace haptic::test {

/// Whether two triangles meet, by CGAL's exact predicates.
bool cgal_triangles_meet(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

/// Indices of all triangles of a that meet triangles of b, sorted: CGAL's box_intersection_d and
/// exact predicates.
std::vector<std::pair<uint32_t, uint32_t>> cgal_triangle_pairs(
    const std::vector<std::array<Vec3, 3>>& a, const std::vector<std::array<Vec3, 3>>& b);

/// What CGAL says of a surface.
struct CgalSurface {
  bool is_manifold = false, is_closed = false;
  bool faces_out = false;         // of a closed one
  size_t self_intersections = 0;  // pairs of triangles that meet beyond what they share
};
CgalSurface cgal_surface(std::span<const Vec3> vertices,
                         std::span<const std::array<uint32_t, 3>> triangles);

/// Distance of the convex hulls of two sets of points by CGAL's exact quadratic program [m].
double cgal_polytope_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

/// A PLY file as CGAL reads it; colours are red, green and blue.
struct CgalPly {
  bool is_read = false;
  std::vector<Vec3> points;
  std::vector<std::vector<size_t>> polygons;
  std::vector<std::array<uint8_t, 3>> point_colours, polygon_colours;
};
CgalPly cgal_read_ply(const std::string& bytes);

}  // namespace haptic::test

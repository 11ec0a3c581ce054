// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/convex/hull.h"

namespace haptic {

/// A convex hull, and which point each of its vertices is.
struct PointsHull {
  HullData hull;
  std::vector<uint32_t> point_of;  // of each vertex: index of the first such point
};

/// Convex hull of points by CGAL's convex_hull_3 with exact predicates; the vertices keep their
/// coordinates. Neighbouring triangles within 1e-8 of the longest extent of a plane are one
/// polygon, and a vertex on the edge of two polygons is left out, so hull_defect() finds nothing at
/// a tolerance of 1e-7 of that extent. Points that lie in a plane to 1e-7 give a polygon with two
/// sides, each a face. No face is virtual and none has a triangle: the caller knows the surface.
/// Points on a line, fewer than three of them or one that is not finite: throws InputError.
PointsHull hull_of_points(std::span<const Vec3> points);

}  // namespace haptic

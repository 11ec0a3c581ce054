// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Polygons as in a file: any number of corners, not connected; file units.
struct PolygonSoup {
  std::vector<Vec3> points;
  std::vector<std::vector<size_t>> polygons;
};

/// Triangulates a polygon of n corners, planar or not, into n − 2 triangles of corner indices with
/// the polygon's orientation: the constrained Delaunay triangulation of its projection along the
/// axis nearest to its normal. Such a projection only drops a coordinate, so with exact predicates
/// nothing is rounded, and a simple polygon can always be triangulated. The result does not depend
/// on the first corner or the orientation. Collinear corners have no area and become a fan. Nothing
/// if the projection touches or crosses itself.
std::optional<std::vector<Triangle>> cut_polygon(std::span<const Vec3> corners);

/// Throws MeshError with the number of the face, from 1, if one cannot be triangulated.
void check_polygons(const PolygonSoup& soup, const std::string& name);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "contact/bake/read.h"
#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Cuts a polygon of n corners, planar or not, into n − 2 triangles of corner numbers that turn as
/// the polygon does: the constrained Delaunay triangulation of its projection along the axis that
/// its normal is nearest to. A projection along an axis only drops a coordinate, so with exact
/// predicates nothing is rounded, and a triangulation of a simple polygon always exists. The result
/// does not depend on where the corners begin or which way they turn. Corners on one line have no
/// area and become a fan. Nothing, where the projection touches or crosses itself.
std::optional<std::vector<Triangle>> cut_polygon(std::span<const Vec3> corners);

/// Throws MeshError with the number of the face, from 1, for one that cannot be cut.
void check_polygons(const PolygonSoup& soup, const std::string& name);

}  // namespace haptic

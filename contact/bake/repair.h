// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/bake/read.h"
#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Makes a soup in metres a clean triangle mesh with CGAL and says in the report what it did:
/// merges points, drops faces without area and faces that are there twice, cuts polygons into
/// triangles, makes orientation consistent, splits what is not a manifold, closes seams, turns
/// closed parts outward, counts borders, parts and self-intersections. Vertices are numbered by
/// first use, so that the file format leaves no trace. Throws MeshError for a polygon that crosses
/// itself, for no face with area, and for an open mesh without allow_open.
Soup repair_soup(PolygonSoup soup, bool allow_open, BakeReport& report);

}  // namespace haptic

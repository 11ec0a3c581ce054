// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/bake/soup/polygons.h"
#include "contact/bake/soup/report.h"
#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Turns a soup in metres into a clean triangle mesh with CGAL, and reports what it did: merges
/// points, drops zero-area and duplicate faces, triangulates polygons, makes the orientation
/// consistent, splits non-manifold edges and vertices, stitches seams, orients closed parts
/// outwards, counts borders, parts and self-intersections. Vertices are numbered by first use, so
/// that the result does not depend on the file format. Throws MeshError for a polygon that crosses
/// itself, if no face has an area, and for an open mesh without allow_open.
Soup repair_soup(PolygonSoup soup, bool allow_open, BakeReport& report);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake_read.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>

#include <algorithm>
#include <cmath>
#include <exception>

namespace haptic {
namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Polygons = std::vector<std::vector<size_t>>;

bool read_soup(const std::string& path, MeshFormat format, std::vector<Point>& points,
               Polygons& polygons) {
  // by scanned format: CGAL would go by the case of the extension
  switch (format) {
    case MeshFormat::kObj:
      return CGAL::IO::read_OBJ(path, points, polygons);
    case MeshFormat::kOff:
      return CGAL::IO::read_OFF(path, points, polygons);
    case MeshFormat::kPly:
      return CGAL::IO::read_PLY(path, points, polygons);
    case MeshFormat::kStl:
      return CGAL::IO::read_STL(path, points, polygons);
  }
  return false;
}

}  // namespace

void check_soup(const PolygonSoup& soup, const std::string& name) {
  for (size_t i = 0; i < soup.points.size(); ++i) {
    const auto& p = soup.points[i];
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) continue;
    throw MeshError(name + ": vertex " + std::to_string(i + 1) +
                    " has a coordinate that is not finite; export the mesh again");
  }
  for (size_t f = 0; f < soup.polygons.size(); ++f) {
    const auto& polygon = soup.polygons[f];
    if (std::all_of(polygon.begin(), polygon.end(),
                    [&](size_t i) { return i < soup.points.size(); })) {
      continue;
    }
    throw MeshError(name + ": face " + std::to_string(f + 1) +
                    " has a vertex index out of range; export the mesh again");
  }
}

PolygonSoup read_mesh_file(const std::string& path, const MeshFileFacts& facts) {
  PolygonSoup soup;
  std::vector<Point> points;
  bool read = false;
  try {
    read = read_soup(path, facts.format, points, soup.polygons);
  } catch (const std::exception& error) {
    throw MeshError(path + ": cannot be read (" + error.what() + "); export the mesh again");
  }
  // a reader that stops early must not give half an object
  if (!read || soup.polygons.size() != facts.polygons) {
    throw MeshError(path + ": " + std::to_string(soup.polygons.size()) + " of " +
                    std::to_string(facts.polygons) +
                    " faces can be read: damaged or truncated; export the mesh again");
  }
  soup.points.reserve(points.size());
  for (const Point& p : points) soup.points.push_back({p.x(), p.y(), p.z()});
  check_soup(soup, path);
  return soup;
}

}  // namespace haptic

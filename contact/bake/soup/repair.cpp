// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/soup/repair.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>

#include "contact/bake/soup/polygons.h"

namespace haptic {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;

/// A polygon soup in CGAL's types, whose functions split and merge points.
struct CgalSoup {
  std::vector<Point> points;
  std::vector<std::vector<size_t>> polygons;
};

constexpr unsigned kMaxIntersections = 100000;  // pairs; broken meshes have millions

/// "1 face", "2 faces".
std::string counted(size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// Removes repeated consecutive corners. A polygon that then has a corner twice has no area: one
/// with an area that touches itself was rejected before.
bool has_no_area(std::vector<size_t>& polygon) {
  polygon.erase(std::unique(polygon.begin(), polygon.end()), polygon.end());
  while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
  return polygon.size() < 3 ||
         std::set<size_t>(polygon.begin(), polygon.end()).size() < polygon.size();
}

void merge_and_drop(CgalSoup& soup, BakeReport& report) {
  auto& [points, polygons] = soup;
  pmp::merge_duplicate_points_in_polygon_soup(points, polygons);
  report.degenerate_removed += std::erase_if(polygons, has_no_area);
  report.duplicate_removed = pmp::merge_duplicate_polygons_in_polygon_soup(
      points, polygons, CGAL::parameters::require_same_orientation(false));
  if (report.duplicate_removed > 0) {
    report.lines.push_back(counted(report.duplicate_removed, "face that was", "faces that were") +
                           " there twice removed");
  }
  pmp::remove_isolated_points_in_polygon_soup(points, polygons);
}

/// Triangles are unchanged. The polygons were checked before points were merged, which does not
/// move them.
void cut_polygons(CgalSoup& soup, const BakeReport& report) {
  std::vector<std::vector<size_t>> triangles;
  triangles.reserve(soup.polygons.size());
  std::vector<Vec3> corners;
  for (std::vector<size_t>& polygon : soup.polygons) {
    if (polygon.size() == 3) {
      triangles.push_back(std::move(polygon));
      continue;
    }
    corners.clear();
    for (const size_t i : polygon) {
      corners.push_back({soup.points[i].x(), soup.points[i].y(), soup.points[i].z()});
    }
    const auto cut = cut_polygon(corners);
    if (!cut) throw MeshError(report.file + ": a face crosses itself; triangulate on export");
    for (const auto& [a, b, c] : *cut) triangles.push_back({polygon[a], polygon[b], polygon[c]});
  }
  soup.polygons = std::move(triangles);
}

void orient_faces(CgalSoup& soup, BakeReport& report) {
  const std::vector<std::vector<size_t>> before = soup.polygons;
  const size_t n_points = soup.points.size();
  pmp::orient_polygon_soup(soup.points, soup.polygons);
  size_t turned = 0;
  for (size_t f = 0; f < before.size(); ++f) {
    // corners may have been split: compare positions
    const auto &now = soup.polygons[f], &was = before[f];
    const auto at = [&](size_t i) { return soup.points[i]; };
    const auto first =
        std::find_if(now.begin(), now.end(), [&](size_t i) { return at(i) == at(was[0]); });
    const size_t next = static_cast<size_t>(first - now.begin() + 1) % now.size();
    turned += at(now[next]) != at(was[1]);
  }
  if (turned > 0) {
    report.reoriented = true;
    report.lines.push_back(counted(turned, "face", "faces") +
                           " turned over: the orientation was not consistent");
  }
  report.non_manifold_split += soup.points.size() - n_points;
}

Mesh connect_faces(CgalSoup& soup, BakeReport& report) {
  if (!pmp::is_polygon_soup_a_polygon_mesh(soup.polygons)) {
    throw MeshError(report.file +
                    ": the faces cannot be made a surface (edges with more than two "
                    "faces); repair it in a mesh editor");
  }
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.polygons, mesh);
  return mesh;
}

void drop_degenerate(Mesh& mesh, BakeReport& report) {
  std::vector<Mesh::Face_index> degenerate;
  pmp::degenerate_faces(mesh, std::back_inserter(degenerate));
  if (!degenerate.empty()) {
    const bool all = pmp::remove_degenerate_faces(mesh);
    mesh.collect_garbage();
    std::vector<Mesh::Face_index> left;
    pmp::degenerate_faces(mesh, std::back_inserter(left));
    report.degenerate_removed += degenerate.size() - std::min(left.size(), degenerate.size());
    if (!all) {
      report.lines.push_back(counted(left.size(), "triangle", "triangles") +
                             " without area could not be removed");
    }
  }
  if (report.degenerate_removed > 0) {
    report.lines.push_back(counted(report.degenerate_removed, "triangle", "triangles") +
                           " without area removed");
  }
  if (mesh.number_of_faces() == 0) {
    throw MeshError(report.file + ": no triangle has an area; export a surface");
  }
}

void split_and_close(Mesh& mesh, BakeReport& report) {
  report.non_manifold_split += pmp::duplicate_non_manifold_vertices(mesh);
  if (!CGAL::is_closed(mesh)) pmp::stitch_borders(mesh);
  mesh.collect_garbage();
  if (report.non_manifold_split > 0) {
    report.lines.push_back(counted(report.non_manifold_split, "vertex", "vertices") +
                           " split where parts touch at an edge or a point (not a manifold)");
  }
}

void check_borders(const Mesh& mesh, bool allow_open, BakeReport& report) {
  std::ostringstream where;
  for (const auto h : mesh.halfedges()) {
    if (!mesh.is_border(h)) continue;
    const Point& p = mesh.point(mesh.target(h));
    if (report.border_edges++ == 0) {
      where << "(" << 1e3 * p.x() << ", " << 1e3 * p.y() << ", " << 1e3 * p.z() << ") mm";
    }
  }
  report.closed = report.border_edges == 0;
  if (report.closed) return;
  const std::string edges = counted(report.border_edges, "border edge", "border edges");
  if (!allow_open) {
    throw MeshError(
        report.file + " is not closed: " + edges + ", first near " + where.str() +
        "; close the mesh, or add --allow-open (in a session file: open = true) to use it as a "
        "one-sided surface");
  }
  report.lines.push_back("open: " + edges + ", first near " + where.str() +
                         "; used as a one-sided surface");
}

/// The three corners of each face, from the source of its first half-edge.
std::vector<std::array<Mesh::Vertex_index, 3>> face_corners(const Mesh& mesh) {
  std::vector<std::array<Mesh::Vertex_index, 3>> corners;
  for (const auto f : mesh.faces()) {
    const auto h = mesh.halfedge(f);
    corners.push_back({mesh.source(h), mesh.target(h), mesh.target(mesh.next(h))});
  }
  return corners;
}

/// Six times the volume enclosed by faces, relative to one of their points: negative if they face
/// inwards.
double signed_volume(const Mesh& mesh, const std::vector<Mesh::Face_index>& faces) {
  const Point& origin = mesh.point(mesh.target(mesh.halfedge(faces.front())));
  double sum = 0;
  for (const auto f : faces) {
    const auto h = mesh.halfedge(f);
    sum +=
        CGAL::determinant(mesh.point(mesh.source(h)) - origin, mesh.point(mesh.target(h)) - origin,
                          mesh.point(mesh.target(mesh.next(h))) - origin);
  }
  return sum;
}

/// Orients each part separately, for a mesh whose parts intersect.
void turn_parts_outward(Mesh& mesh) {
  std::vector<std::vector<Mesh::Face_index>> parts;
  const auto part_of = mesh.add_property_map<Mesh::Face_index, size_t>("f:own_part").first;
  parts.resize(pmp::connected_components(mesh, part_of));
  for (const auto f : mesh.faces()) parts[part_of[f]].push_back(f);
  for (const auto& part : parts) {
    if (signed_volume(mesh, part) < 0) pmp::reverse_face_orientations(part, mesh);
  }
}

void turn_outward(Mesh& mesh, BakeReport& report) {
  if (!report.closed) return;
  const auto before = face_corners(mesh);
  // cavities stay cavities, if the nesting of parts is well defined
  if (report.self_intersections == 0) {
    pmp::orient_to_bound_a_volume(mesh);
  } else {
    turn_parts_outward(mesh);
  }
  const auto after = face_corners(mesh);
  size_t turned = 0;
  for (size_t f = 0; f < before.size(); ++f) {
    const auto& now = after[f];
    const auto first = std::find(now.begin(), now.end(), before[f][0]);
    turned += now[static_cast<size_t>(first - now.begin() + 1) % 3] != before[f][1];
  }
  if (turned == 0) return;
  report.reoriented = true;
  report.lines.push_back(counted(turned, "face", "faces") +
                         " turned over: a closed part was inside out");
}

void count_intersections(const Mesh& mesh, BakeReport& report) {
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
  pmp::self_intersections(mesh, std::back_inserter(pairs),
                          CGAL::parameters::maximum_number(kMaxIntersections));
  report.self_intersections = pairs.size();
  if (pairs.empty()) return;
  const std::string least = pairs.size() >= kMaxIntersections ? "at least " : "";
  report.lines.push_back("warning: " + least + counted(pairs.size(), "pair", "pairs") +
                         " of faces cut each other; inside and outside are mixed up there");
}

Soup number_by_first_use(const Mesh& mesh) {
  Soup soup;
  std::vector<uint32_t> number(mesh.num_vertices(), kNoFace);
  for (const auto f : mesh.faces()) {
    Triangle triangle{};
    size_t corner = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      uint32_t& n = number[v];
      if (n == kNoFace) {
        n = static_cast<uint32_t>(soup.vertices.size());
        const Point& p = mesh.point(v);
        soup.vertices.push_back({p.x(), p.y(), p.z()});
      }
      triangle[corner++] = n;
    }
    soup.triangles.push_back(triangle);
  }
  return soup;
}

/// CGAL prints its errors before it throws; here they become one line.
void be_quiet() {
  const auto say_nothing = [](const char*, const char*, const char*, int, const char*) {};
  CGAL::set_error_handler(say_nothing);
  CGAL::set_warning_handler(say_nothing);
}

Soup repair(PolygonSoup raw, bool allow_open, BakeReport& report) {
  check_polygons(raw, report.file);
  CgalSoup soup{{}, std::move(raw.polygons)};
  soup.points.reserve(raw.points.size());
  for (const Vec3& p : raw.points) soup.points.emplace_back(p.x, p.y, p.z);
  merge_and_drop(soup, report);
  cut_polygons(soup, report);
  orient_faces(soup, report);
  Mesh mesh = connect_faces(soup, report);
  drop_degenerate(mesh, report);
  split_and_close(mesh, report);
  check_borders(mesh, allow_open, report);
  count_intersections(mesh, report);
  turn_outward(mesh, report);
  auto parts = mesh.add_property_map<Mesh::Face_index, size_t>("f:part").first;
  report.components = pmp::connected_components(mesh, parts);
  Soup clean = number_by_first_use(mesh);
  report.vertices = clean.vertices.size();
  report.triangles = clean.triangles.size();
  return clean;
}

}  // namespace

Soup repair_soup(PolygonSoup raw, bool allow_open, BakeReport& report) {
  be_quiet();
  try {
    return repair(std::move(raw), allow_open, report);
  } catch (const CGAL::Failure_exception& failure) {
    throw MeshError(report.file + ": its faces are too entangled to be made a surface (" +
                    failure.expression() + "); repair it in a mesh editor");
  }
}

}  // namespace haptic

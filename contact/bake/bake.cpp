// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/bake.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "contact/bake/cache.h"
#include "contact/bake/eye.h"
#include "contact/bake/grid.h"
#include "contact/bake/soup/read.h"
#include "contact/bake/soup/repair.h"
#include "contact/shape/baked/file.h"
#include "contact/shape/mesh/box.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/config/quantity.h"
#include "proto/config/read/config_shape.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr size_t kEyeTriangles = 20000;  // of the mesh for display
constexpr double kSizeTolerance = 0.01;  // relative, between the stated and the measured size
// [m]; smaller coordinates become 0, so that the fourth powers of lengths in normals do not
// underflow
constexpr double kSmallestCoordinate = 1e-40;
constexpr size_t kCachedTriangles = 5000;  // a generated mesh of fewer is made faster than mapped

std::string millimetres(double metres) {
  std::ostringstream text;
  text << 1e3 * metres << " mm";
  return text.str();
}

std::string unit_name(double unit) {
  if (unit == 1e-3) return "'mm'";
  if (unit == 1e-2) return "'cm'";
  if (unit == 1) return "'m'";
  if (unit == 0.0254) return "'inch'";
  return "of " + millimetres(unit);
}

/// Extent of the points that faces use.
struct Extent {
  double longest = 0;   // longest side of the bounding box
  double furthest = 0;  // largest coordinate, absolute
};

/// In file units.
Extent extent_of(const PolygonSoup& soup, const std::string& file) {
  std::optional<Box> box;
  for (const auto& polygon : soup.polygons) {
    for (const size_t i : polygon) {
      if (!box) box = {soup.points[i], soup.points[i]};
      box->add(soup.points[i]);
    }
  }
  if (!box || !(longest_of(box->size()) > 0))
    throw MeshError(file + ": no triangle has an area; export a surface");
  return {longest_of(box->size()),
          std::max(largest_coordinate(box->lower), largest_coordinate(box->upper))};
}

/// Rejects coordinates that double cannot resolve, and sides whose areas vanish in rounding: the
/// unit is wrong.
void check_extent(const Extent& extent, double scale, const std::string& file) {
  const auto metres = [](double length) { return quantity_text(length, Dimension::kLength); };
  const std::string mend =
      " at unit " + unit_name(scale) + "; state the right unit, or unit = \"any\" and a size";
  // written so that overflow is rejected
  if (!(scale * extent.furthest <= kMostLength && std::isfinite(extent.longest))) {
    throw MeshError(file + ": its largest coordinate is " + number_text(extent.furthest) +
                    ", at most " + number_text(kMostLength / scale) + " (" + metres(kMostLength) +
                    ") is allowed" + mend);
  }
  // a mesh scaled to the least size is that up to rounding
  if (!(scale * extent.longest >= (1 - kSizeTolerance) * kMeshSizes.min)) {
    throw MeshError(file + ": its longest side is " + number_text(extent.longest) + ", at least " +
                    number_text(kMeshSizes.min / scale) + " (" + metres(kMeshSizes.min) +
                    ") is wanted" + mend);
  }
}

/// File units to metres. Compares with the stated size, if any; without unit and size the numbers
/// are metres.
void scale_to_metres(PolygonSoup& soup, const ShapeConfig& object, BakeReport& report) {
  const Extent extent = extent_of(soup, report.file);
  const double longest = extent.longest;
  const bool any_unit = object.unit == 0 && object.size > 0;
  const double scale = any_unit ? object.size / longest : object.unit > 0 ? object.unit : 1;
  check_extent(extent, scale, report.file);
  report.size = scale * longest;
  if (object.size > 0 && std::fabs(report.size - object.size) > kSizeTolerance * object.size) {
    throw MeshError(report.file + ": states size " + millimetres(object.size) +
                    " but the file at unit " + unit_name(object.unit) + " is " +
                    millimetres(report.size) +
                    ": correct unit or size, or unit = \"any\" to scale");
  }
  for (Vec3& p : soup.points) {
    for (int k = 0; k < 3; ++k) {
      p[k] *= scale;
      if (std::fabs(p[k]) < kSmallestCoordinate) p[k] = 0;
    }
  }
}

/// The report as text: a line of numbers, then its lines.
std::string write_report(const BakeReport& r) {
  std::ostringstream text;
  text.precision(17);
  text << r.vertices << " " << r.triangles << " " << r.closed << " " << r.components << " "
       << r.border_edges << " " << r.degenerate_removed << " " << r.duplicate_removed << " "
       << r.non_manifold_split << " " << r.self_intersections << " " << r.reoriented << " "
       << r.size << "\n";
  for (const std::string& line : r.lines) text << line << "\n";
  return text.str();
}

BakeReport read_report(std::span<const char> notes, const std::string& file) {
  std::istringstream text(std::string(notes.data(), notes.size()));
  BakeReport r;
  r.file = file;
  text >> r.vertices >> r.triangles >> r.closed >> r.components >> r.border_edges >>
      r.degenerate_removed >> r.duplicate_removed >> r.non_manifold_split >> r.self_intersections >>
      r.reoriented >> r.size;
  std::string line;
  std::getline(text, line);
  while (std::getline(text, line)) r.lines.push_back(line);
  return r;
}

BakedShape make_shape(std::span<const std::byte> bytes, std::shared_ptr<const void> storage,
                      uint64_t key, const std::string& file) {
  const BakedContent content = view_baked(bytes, key, run_on_two_threads);
  return {content.shape,
          content.eye_vertices,
          content.eye_normals,
          content.eye_triangles,
          read_report(content.notes, file),
          std::move(storage)};
}

/// The share of the time of baking that has passed after each part, of meshes of 50,000 to 90,000
/// triangles; of half a million the mesh for the eye takes four fifths.
struct BakedShare {
  double read = 0.05, repaired = 0.4, searchable = 0.5;
};

/// Everything from the soup in file units to the block that is mapped later. `tell` is called with
/// the share of the work that is done.
std::vector<std::byte> bake_bytes(
    PolygonSoup soup, const ShapeConfig& object, const std::string& file, uint64_t key,
    const std::function<void(double)>& tell = [](double) {}) {
  constexpr BakedShare kDone;
  BakeReport report;
  report.file = file;
  check_soup(soup, file);
  scale_to_metres(soup, object, report);
  tell(kDone.read);
  Soup clean = repair_soup(std::move(soup), object.allow_open != 0, report);
  tell(kDone.repaired);
  const MeshData mesh = build_mesh(std::move(clean.vertices), std::move(clean.triangles));
  const SearchStructures built = build_search_structures(mesh.view());
  tell(kDone.searchable);
  const MeshData eye = build_eye_mesh(mesh.view(), kEyeTriangles);
  tell(1);
  const std::string notes = write_report(report);
  return write_baked({{mesh.view(), built.tree.view(), built.grid.view(), built.patches.view()},
                      eye.vertices,
                      eye.vertex_normals,
                      eye.triangles,
                      {notes.data(), notes.size()}},
                     key);
}

BakedShape shape_in_memory(std::vector<std::byte> bytes, uint64_t key, const std::string& file) {
  const auto storage = std::make_shared<std::vector<std::byte>>(std::move(bytes));
  return make_shape(*storage, storage, key, file);
}

uint64_t content_key(std::span<const std::byte> file_bytes, const std::string& path,
                     const ShapeConfig& object) {
  std::ostringstream options;
  // the accepted sizes are part of the key: a version with other limits may have filled the cache
  options << std::hexfloat << object.unit << " " << object.size << " " << object.allow_open << " "
          << kMeshSizes.min << " " << kMeshSizes.max << " " << kBakeVersion << " "
          << std::filesystem::path(path).extension().string();
  const std::string text = options.str();
  return hash_bytes(file_bytes, hash_bytes(std::as_bytes(std::span(text))));
}

MappedFile open_mesh(const std::string& path) {
  try {
    return map_file(path);
  } catch (const std::runtime_error& error) {
    throw MeshError(path + ": " + error.what() + "; check the path");
  }
}

/// From the cache, else baked and cached.
BakedShape bake_cached(const std::string& name, uint64_t key, const ByteMaker& bake) {
  BakedShape shape;
  const CacheUse use = use_cached(
      key, [&](const MappedFile& file) { shape = make_shape(file.bytes, file.storage, key, name); },
      bake);
  shape.report.from_cache = use.from_cache;
  // these concern this run, not the mesh: they are not cached
  shape.report.lines.insert(shape.report.lines.end(), use.lines.begin(), use.lines.end());
  return shape;
}

/// Progress of reading and checking a mesh.
std::function<void(double share)> teller(const std::string& file, const BakeProgress& progress) {
  return [stage = "reading and checking " + shown(file), progress](double share) {
    if (progress) progress(stage, share);
  };
}

BakedShape bake_file(const ShapeConfig& object, const std::string& path, uint64_t memory_limit,
                     const BakeProgress& progress) {
  const MappedFile file = open_mesh(path);
  const uint64_t key = content_key(file.bytes, path, object);
  return bake_cached(path, key, [&] {
    const auto tell = teller(std::filesystem::path(path).filename().string(), progress);
    tell(0);
    const std::string_view text(reinterpret_cast<const char*>(file.bytes.data()),
                                file.bytes.size());
    return bake_bytes(read_mesh(text, path, memory_limit), object, path, key, tell);
  });
}

PolygonSoup polygons_of(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
  PolygonSoup soup;
  soup.points = vertices;
  soup.polygons.reserve(triangles.size());
  for (const auto& [a, b, c] : triangles) soup.polygons.push_back({a, b, c});
  return soup;
}

BakedShape bake_primitive(const ShapeConfig& object, const BakeProgress& progress) {
  const Soup soup = make_mesh(object.primitive);
  const std::string name = mesh_name(object);
  // made in metres: there is no file to disagree with
  ShapeConfig metres = object;
  metres.unit = metres.size = 0;
  if (soup.triangles.size() < kCachedTriangles) {
    return bake_soup(soup.vertices, soup.triangles, metres);
  }
  const std::array corners = {hash_bytes(std::as_bytes(std::span(soup.vertices))),
                              hash_bytes(std::as_bytes(std::span(soup.triangles)))};
  const uint64_t key = content_key(std::as_bytes(std::span(corners)), name, metres);
  return bake_cached(name, key, [&] {
    const auto tell = teller(std::string(kind_name(object.primitive)), progress);
    tell(0);
    return bake_bytes(polygons_of(soup.vertices, soup.triangles), metres, name, key, tell);
  });
}

}  // namespace

BakedShape bake_contents(std::string_view bytes, const ShapeConfig& object, uint64_t memory_limit) {
  const std::string name(view(object.mesh));
  return shape_in_memory(bake_bytes(read_mesh(bytes, name, memory_limit), object, name, 0), 0,
                         name);
}

BakedShape bake_soup(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                     const ShapeConfig& object) {
  PolygonSoup soup = polygons_of(vertices, triangles);
  const std::string name =
      has_mesh(object) ? mesh_name(object) : "mesh '" + std::string(view(object.name)) + "'";
  return shape_in_memory(bake_bytes(std::move(soup), object, name, 0), 0, name);
}

BakedShape bake_object(const ShapeConfig& object, uint64_t memory_limit,
                       const BakeProgress& progress) {
  const std::string name = mesh_name(object);
  try {
    if (object.primitive.index() > 0) return bake_primitive(object, progress);
    return bake_file(object, name, memory_limit, progress);
  } catch (const std::bad_alloc&) {
    throw MeshError(name +
                    ": there is not enough memory to prepare it; use a coarser mesh, or set "
                    "mesh_memory_limit to what this machine can spare");
  }
}

}  // namespace haptic

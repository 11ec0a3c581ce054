// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/soup/read.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "contact/bake/soup/formats.h"
#include "contact/bake/soup/report.h"

namespace haptic {
namespace {

// peak memory of baking, measured on spheres of 0.3 and 1.3 million triangles
constexpr uint64_t kBakeBytesPerTriangle = 1000;
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // of UTF-8

std::string mebibytes(double bytes) {
  return std::to_string(static_cast<uint64_t>(std::ceil(bytes / (1 << 20)))) + " MiB";
}

double bytes_to_bake(uint64_t triangles) {
  return static_cast<double>(triangles) * static_cast<double>(kBakeBytesPerTriangle);
}

using FormatReader = void (*)(std::string_view bytes, SoupReader& reader);

FormatReader reader_for(const std::string& extension) {
  if (extension == ".obj") return read_obj;
  if (extension == ".off") return read_off;
  if (extension == ".ply") return read_ply;
  if (extension == ".stl") return read_stl;
  return nullptr;
}

}  // namespace

void SoupReader::fail(const std::string& what) const {
  throw MeshError(path_ + ": " + what);
}

bool SoupReader::fits() const {
  return bytes_to_bake(n_triangles_) <= static_cast<double>(memory_limit_);
}

void SoupReader::add_polygon(std::vector<size_t> corners) {
  ++n_polygons_;
  n_triangles_ += corners.size() > 2 ? corners.size() - 2 : 0;
  if (fits()) soup_.polygons.push_back(std::move(corners));
}

void SoupReader::check_memory(uint64_t triangles) const {
  const double needed = bytes_to_bake(triangles);
  if (needed <= static_cast<double>(memory_limit_)) return;
  fail(std::to_string(triangles) + " triangles need about " + mebibytes(needed) +
       " while baking and contact.mesh_memory_limit allows " +
       mebibytes(static_cast<double>(memory_limit_)) +
       "; decimate the mesh or raise contact.mesh_memory_limit");
}

void SoupReader::check_announced(uint64_t vertices, uint64_t polygons, double bytes_needed) const {
  const bool is_possible = bytes_needed <= static_cast<double>(file_bytes_);
  try {
    check_memory(polygons);
  } catch (const MeshError& error) {
    if (is_possible) throw;
    throw MeshError(std::string(error.what()) + " (or mend its header: a file of " +
                    std::to_string(file_bytes_) + " bytes cannot hold that many)");
  }
  if (is_possible) return;
  fail("announces " + std::to_string(vertices) + " vertices and " + std::to_string(polygons) +
       " faces, but " + std::to_string(file_bytes_) +
       " bytes cannot hold them: truncated or damaged; export it again");
}

PolygonSoup SoupReader::take() {
  check_memory(n_triangles_);
  if (n_polygons_ == 0) fail("no triangles; export a surface, not points or lines");
  return std::move(soup_);
}

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

PolygonSoup read_mesh(std::string_view bytes, const std::string& path, uint64_t memory_limit) {
  SoupReader reader(path, bytes.size(), memory_limit);
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const FormatReader read = reader_for(extension);
  if (read == nullptr) {
    reader.fail("unknown extension '" + extension + "'; use .obj, .stl, .ply or .off");
  }
  if (bytes.empty()) reader.fail("the file is empty; export the mesh again");
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  read(bytes, reader);
  PolygonSoup soup = reader.take();
  check_soup(soup, path);
  return soup;
}

}  // namespace haptic

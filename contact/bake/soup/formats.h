// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake/soup/polygons.h"

namespace haptic {

/// Collects points and polygons while a file is read. Beyond the memory limit polygons are only
/// counted, so that the error message can give their number.
class SoupReader {
 public:
  SoupReader(std::string path, size_t file_bytes, uint64_t memory_limit)
      : path_(std::move(path)), file_bytes_(file_bytes), memory_limit_(memory_limit) {}

  const std::string& path() const { return path_; }
  size_t n_points() const { return soup_.points.size(); }
  size_t n_polygons() const { return n_polygons_; }

  void add_point(const Vec3& p) { soup_.points.push_back(p); }
  void add_polygon(std::vector<size_t> corners);
  /// Throws MeshError if the counts of a header need more than the memory limit, or more bytes than
  /// the file has.
  void check_announced(uint64_t vertices, uint64_t polygons, double bytes_needed) const;
  /// Throws MeshError "path: what".
  [[noreturn]] void fail(const std::string& what) const;
  /// The soup. Throws MeshError if it exceeds the memory limit or has no polygons.
  PolygonSoup take();

 private:
  bool fits() const;
  void check_memory(uint64_t triangles) const;

  std::string path_;
  size_t file_bytes_;
  uint64_t memory_limit_;
  PolygonSoup soup_;
  size_t n_polygons_ = 0;
  uint64_t n_triangles_ = 0;
};

// one per format: each reads the whole file, or throws MeshError
void read_obj(std::string_view bytes, SoupReader& reader);
void read_off(std::string_view bytes, SoupReader& reader);
void read_ply(std::string_view bytes, SoupReader& reader);
void read_stl(std::string_view bytes, SoupReader& reader);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake.h"

namespace haptic {

/// Polygons as they stand in a file: any number of corners, nothing connected yet; file units.
struct PolygonSoup {
  std::vector<Vec3> points;
  std::vector<std::vector<size_t>> polygons;
};

enum class MeshFormat : uint32_t { kObj, kOff, kPly, kStl };

/// What a mesh file holds by its own account.
struct MeshFileFacts {
  MeshFormat format = MeshFormat::kObj;
  uint64_t polygons = 0;
};

/// Looks through a mesh file without storing anything, for what the readers accept silently or
/// choke on: unknown extension, empty, truncated, more elements than the file or the memory limit
/// can hold, coordinates that are not finite, indices out of range, no faces. Throws MeshError with
/// the line where the format has lines. `path` names the file and its format.
MeshFileFacts scan_mesh_file(std::string_view bytes, const std::string& path,
                             uint64_t memory_limit);

/// Reads a scanned file with CGAL, coordinates in double. Throws MeshError.
PolygonSoup read_mesh_file(const std::string& path, const MeshFileFacts& facts);

/// Throws MeshError for coordinates that are not finite and indices out of range.
void check_soup(const PolygonSoup& soup, const std::string& name);

/// Throws MeshError where a mesh of that many triangles would need more than memory_limit bytes.
void check_mesh_memory(uint64_t triangles, uint64_t memory_limit, const std::string& path);

}  // namespace haptic

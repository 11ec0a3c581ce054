// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "contact/bake/bake.h"

namespace haptic {

/// Polygons as they stand in a file: any number of corners, nothing connected yet; file units.
struct PolygonSoup {
  std::vector<Vec3> points;
  std::vector<std::vector<size_t>> polygons;
};

/// Reads the bytes of a mesh file, coordinates in double. Nothing is taken on trust: an unknown
/// extension, an empty or truncated file, more elements than the file or the memory limit [bytes]
/// can hold, coordinates that are not finite, indices out of range and no faces throw MeshError,
/// with the line where the format has lines. `path` names the file and, by its extension, the
/// format. Takes time in proportion to the bytes.
PolygonSoup read_mesh(std::string_view bytes, const std::string& path, uint64_t memory_limit);

/// Throws MeshError for coordinates that are not finite and indices out of range.
void check_soup(const PolygonSoup& soup, const std::string& name);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "contact/bake/soup/polygons.h"

namespace haptic {

/// Reads the bytes of a mesh file, coordinates in double. Untrusted input: throws MeshError, with
/// the line number for text formats, for an unknown extension, an empty or truncated file, more
/// elements than the file or the memory limit [bytes] can hold, coordinates that are not finite,
/// indices out of range, and no faces. `path` names the file and, by its extension, the format.
/// Linear time in the number of bytes.
PolygonSoup read_mesh(std::string_view bytes, const std::string& path, uint64_t memory_limit);

/// Throws MeshError for coordinates that are not finite and indices out of range.
void check_soup(const PolygonSoup& soup, const std::string& name);

}  // namespace haptic

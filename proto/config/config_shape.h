// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/config/config.h"
#include "proto/config/config_section.h"

namespace haptic {

/// Reads `mesh` or `primitive` of an [[object]] or the [tool], with all keys that go with it;
/// relative paths are taken from the folder of the file. Throws ConfigError.
void read_shape(Section& section, const std::filesystem::path& config_folder, ShapeConfig& shape);

/// Metres per unit of a mesh file: "m", "mm", "cm" or "in", a length as "25.4 mm", or "any": 0. A
/// bare number is meant in `bare_unit`, where there is one. Throws QuantityError.
double parse_mesh_unit(std::string_view text, std::string_view bare_unit = "");

/// Longest side that a mesh may have [m]: from a micrometre, finer than what a device measures, to
/// where its coordinates are no longer resolved.
inline constexpr Range kMeshSizes{1e-6, kMostLength};

}  // namespace haptic

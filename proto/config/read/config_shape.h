// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "proto/config/read/config_section.h"
#include "proto/config/scene_config.h"

namespace haptic {

/// Folders in which a mesh is looked for after that of the config file: $HAPTICD_MESHES, those of
/// this checkout or installation, and what an installed `hapt demo` has fetched.
std::vector<std::filesystem::path> mesh_folders();

/// Reads `mesh` or `primitive` of an [[object]] or the [tool] and the keys that belong to it;
/// relative paths are relative to the folder of the file. Throws ConfigError.
void read_shape(Section& section, const std::filesystem::path& config_folder, ShapeConfig& shape);

/// Reads `colour` of an [[object]] or the [tool], "#rrggbb". Throws ConfigError.
void read_colour(Section& section, ShapeConfig& shape);

/// The colour of object number `index` where the file names none, 0xrrggbb; and that of the tool.
uint32_t default_colour(uint32_t index);
inline constexpr uint32_t kToolColour = 0xd9dde3;

/// Metres per unit of a mesh file: "m", "mm", "cm" or "in", a length such as "25.4 mm", or "any"
/// (0). A number without unit is taken in `bare_unit`, if given. Throws QuantityError.
double parse_mesh_unit(std::string_view text, std::string_view bare_unit = "");

/// Range of a mesh's longest side [m]: from a micrometre, finer than any device measures, to the
/// limit of the resolution of coordinates.
inline constexpr Range kMeshSizes{1e-6, kMostLength};

}  // namespace haptic

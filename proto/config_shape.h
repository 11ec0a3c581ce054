// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/config.h"
#include "proto/config_section.h"

namespace haptic {

/// Reads `mesh` or `primitive` of an [[object]] or the [tool], with all keys that go with it;
/// relative paths are taken from the folder of the file. Throws ConfigError.
void read_shape(Section& section, const std::filesystem::path& config_folder, ShapeConfig& shape);

}  // namespace haptic

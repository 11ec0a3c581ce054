// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/config/read/config_section.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Reads `material` of an [[object]]; the image of a texture is stored in config.images, once per
/// object that names it. Throws ConfigError.
void read_material(Section& object, SessionConfig& config,
                   const std::filesystem::path& config_folder, MaterialConfig& material);

}  // namespace haptic

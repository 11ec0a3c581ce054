// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "proto/config/scene_config.h"

namespace haptic {

/// Reads a grey image, PGM (P2 text or P5 binary, at most 64 × 64, 8 bits). Throws
/// std::runtime_error: what is wrong and how to mend it.
HeightImage read_height_image(const std::string& path);

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/config/read/config_section.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Reads all [[joint]] after the objects that they name. Throws ConfigError.
void read_joints(Section& root, SessionConfig& config);

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/config/read/config_section.h"
#include "proto/config/session_config.h"

namespace haptic {

/// Reads every [[client]]; the objects must have been read.
void read_clients(Section& root, SessionConfig& config);

}  // namespace haptic

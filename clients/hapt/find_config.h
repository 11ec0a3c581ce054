// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "proto/config/config.h"

namespace haptic {

/// Finds a session file by path, or by name in $HAPTICD_CONFIGS or among those that belong to this
/// checkout or installation. Throws ConfigError with the places searched.
std::string find_config(const std::string& name);

}  // namespace haptic

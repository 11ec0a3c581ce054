// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "proto/config/device_config.h"
#include "proto/config/read/config_section.h"

namespace haptic {

/// Reads the keys of one device below [device], and asks for those that it cannot do without if it
/// is the one in use. The others are read as well: a session may be run with another device.
using ReadDevice = void(Section& device, const std::filesystem::path& config_folder,
                        DeviceConfig& config);

/// Reads [device].
void read_device(Section& root, const std::filesystem::path& config_folder, DeviceConfig& device);

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "proto/config/devices.h"
#include "proto/config/read/config_device.h"

namespace haptic {

using enum Dimension;

void read_falcon(Section& device, const std::filesystem::path& config_folder,
                 DeviceConfig& config) {
  device.within("falcon", [&](Section& section) {
    section.read_path("firmware", config_folder, config.falcon.firmware);
    section.read_quantity("velocity_cutoff", kFrequency, kPositive, config.falcon.velocity_cutoff);
  });
}

}  // namespace haptic

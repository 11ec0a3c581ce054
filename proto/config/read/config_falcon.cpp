// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "proto/config/devices.h"
#include "proto/config/read/config_device.h"

namespace haptic {

using enum Dimension;

void read_falcon(Section& device, const std::filesystem::path& config_folder,
                 DeviceConfig& config) {
  auto section = device.section("falcon");
  if (!section) return;
  std::string path;
  if (section->read_text("firmware", path)) {
    const auto file = std::filesystem::absolute(config_folder / path).lexically_normal();
    if (file.string().size() >= config.falcon.firmware.size()) {
      section->fail_at("firmware", "is too long");
    }
    assign(config.falcon.firmware, file.string());
  }
  section->read_quantity("velocity_cutoff", kFrequency, kPositive, config.falcon.velocity_cutoff);
  section->finish();
}

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_device.h"

namespace haptic {

void read_plugged(Section& device, DeviceConfig& config) {
  auto section = device.section("usb");
  if (!section) return;
  section->read_text("serial", config.plugged.serial);
  section->read_text("port", config.plugged.port);
  section->finish();
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/polhem/polhem.h"

#include <memory>
#include <string>

#include "proto/config/devices.h"
#include "proto/os/serial_port.h"

namespace haptic {

std::unique_ptr<Device> open_polhem(const DeviceConfig& config, FileDescriptor node) {
  if (!node.is_open()) node = open_serial_port(std::string(view(config.serial.path)));
  return std::make_unique<Polhem>(config, std::move(node));
}

}  // namespace haptic

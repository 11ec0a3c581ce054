// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "device-io/device.h"
#include "proto/config/devices.h"

namespace haptic {

#define DEVICE(id, name, open, ...) OpenDevice open;
#include "proto/config/devices.def"

std::unique_ptr<Device> open_device(const DeviceConfig& config, FileDescriptor node) {
  static constexpr std::array kOpen{
#define DEVICE(id, name, open, ...) &open,
#include "proto/config/devices.def"
  };
  const auto number = static_cast<size_t>(config.kind);
  if (number < kOpen.size()) return kOpen[number](config, std::move(node));
  std::string known;
  for (const DeviceRow& row : kDevices)
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  throw std::runtime_error("[device] kind has the unknown number " + std::to_string(number) +
                           "; known: " + known);
}

}  // namespace haptic

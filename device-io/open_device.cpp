// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "device-io/device.h"
#include "proto/config/devices.h"
#include "proto/math/assert.h"
#include "proto/os/message.h"

namespace haptic {

#define DEVICE(id, name, open, ...) OpenDevice open;
#include "proto/config/devices.def"

DeviceRelease release_by(ReleaseBy by, std::span<const uint8_t> bytes, uint32_t interface,
                         uint32_t endpoint) {
  DeviceRelease release{bytes.size(), static_cast<uint32_t>(by), interface, endpoint, 0, {}};
  HAPTIC_ASSERT(bytes.size() <= release.bytes.size());
  std::copy(bytes.begin(), bytes.end(), release.bytes.begin());
  return release;
}

std::unique_ptr<Device> open_device(const DeviceConfig& config, FileDescriptor node) {
  static constexpr std::array kOpen{
#define DEVICE(id, name, open, ...) &open,
#include "proto/config/devices.def"
  };
  const auto number = static_cast<size_t>(config.kind);
  if (number < kOpen.size()) return kOpen[number](config, std::move(node));
  throw std::runtime_error("[device] kind has the unknown number " + std::to_string(number) +
                           "; known: " + joined(kDevices, &DeviceRow::name));
}

}  // namespace haptic

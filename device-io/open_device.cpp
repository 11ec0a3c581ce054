// SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>
#include <string>
#include <utility>

#include "device-io/device.h"
#include "device-io/hand/simulated_hand.h"
#include "device-io/replay/replay.h"
#include "device-io/woodenhaptics/woodenhaptics.h"
#include "proto/os/serial_port.h"

namespace haptic {

std::unique_ptr<Device> open_device(const DeviceConfig& config, FileDescriptor node) {
  switch (config.kind) {
    case DeviceKind::kSimulatedHand:
      return std::make_unique<SimulatedHand>(config);
    case DeviceKind::kReplay:
      return std::make_unique<Replay>(config);
    case DeviceKind::kWoodenHaptics:
      if (!node.is_open()) node = open_serial_port(std::string(node_of(config)));
      return std::make_unique<WoodenHaptics>(config, std::move(node));
  }
  std::string known;
  for (const DeviceRow& row : kDevices)
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  throw std::runtime_error("[device] kind has the unknown number " +
                           std::to_string(static_cast<uint32_t>(config.kind)) +
                           "; known: " + known);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>
#include <string>

#include "device-io/device.h"
#include "device-io/replay.h"
#include "device-io/simulated_hand.h"

namespace haptic {

std::unique_ptr<Device> open_device(const DeviceConfig& config) {
  switch (config.kind) {
    case DeviceKind::kSimulatedHand:
      return std::make_unique<SimulatedHand>(config);
    case DeviceKind::kReplay:
      return std::make_unique<Replay>(config);
  }
  throw std::runtime_error("[device] kind has the unknown number " +
                           std::to_string(static_cast<uint32_t>(config.kind)) +
                           "; use \"simulated-hand\" or \"replay\"");
}

}  // namespace haptic

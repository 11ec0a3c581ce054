// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "device-io/owndevice/own_device_arm.h"
#include "device-io/woodenhaptics/motor_device.h"
#include "device-io/woodenhaptics/protocol.h"

namespace haptic {

/// A device of any vendor, driven by a program of its own that speaks the line of
/// docs/your-own-device.md.
class OwnDevice final : public MotorDevice {
 public:
  OwnDevice(const DeviceConfig& config, FileDescriptor node)
      : MotorDevice(own_device_arm(), whole_line(config), std::move(node)) {}

 private:
  /// The numbers of its line are no currents: what limits them is max_force and max_torque alone.
  static DeviceConfig whole_line(DeviceConfig config) {
    config.serial.max_current = 1e-3 * kFirmwareMaxMilliamperes;
    return config;
  }
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/motor_device.h"

namespace haptic {

/// A WoodenHaptics with a Teensy: three sensed and three driven axes, no orientation.
class WoodenHaptics final : public MotorDevice {
 public:
  WoodenHaptics(const DeviceConfig& config, FileDescriptor node)
      : MotorDevice(woodenhaptics_arm(), config, std::move(node)) {}
};

}  // namespace haptic

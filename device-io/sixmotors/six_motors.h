// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "device-io/sixmotors/kinematics.h"
#include "device-io/woodenhaptics/motor_device.h"

namespace haptic {

/// A device of six sensed and six driven axes, which speaks the line of docs/six-motors.md.
class SixMotors final : public MotorDevice {
 public:
  SixMotors(const DeviceConfig& config, FileDescriptor node)
      : MotorDevice(six_motors_arm(), config, std::move(node)) {}
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "device-io/polhem/kinematics.h"
#include "device-io/woodenhaptics/motor_device.h"

namespace haptic {

/// A Polhem with its Teensy firmware, which speaks the line of the WoodenHaptics: six axes sensed,
/// three driven. It takes no torque: that is dropped before the limits, and none is missing.
class Polhem final : public MotorDevice {
 public:
  Polhem(const DeviceConfig& config, FileDescriptor node)
      : MotorDevice(polhem_arm(), config, std::move(node)) {}
};

}  // namespace haptic

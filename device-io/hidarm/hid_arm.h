// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/three_motor_device.h"
#include "device-io/woodenhaptics/kinematics.h"

namespace haptic {

/// A WoodenHaptics over HID, or a relative, whose commands are currents in milliamperes: the arm
/// that a config describes, in the frame B of the WoodenHaptics: x to the hand, z up; its origin,
/// the middle of the workspace, is 0.22 m before the axis of A and at the shoulder's height.
Arm hid_arm(const HidArmConfig& config);
/// It is homed where it was plugged in, so always.
MotorFlags hid_arm_flags();

}  // namespace haptic

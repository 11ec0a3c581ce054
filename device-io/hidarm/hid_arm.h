// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/three_motor_device.h"
#include "device-io/woodenhaptics/kinematics.h"

namespace haptic {

/// The geometry that a config describes, in the frame B of the WoodenHaptics: x to the hand, z up;
/// its origin, the middle of the workspace, is 0.22 m before the axis of A and at the shoulder's
/// height.
WoodenHapticsGeometry hid_arm_geometry(const HidArmConfig& config);

/// A WoodenHaptics over HID, or a relative, as an arm of three motors whose commands are currents
/// in milliamperes. It is homed where it was plugged in, so always.
ThreeMotorArm hid_arm(const HidArmConfig& config);

}  // namespace haptic

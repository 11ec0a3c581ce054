// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/three_motor_device.h"

namespace haptic {

/// A Novint Falcon as an arm of three motors. Frame B as in kinematics.h. Homed: pulled fully out
/// and pushed fully in since it was switched on, by its own bits.
///
/// A sample is one to two ticks old, since the chip holds short answers back for 1 ms: a wall is
/// stable for K < (b + B)/(T/2 + t_d), some 500 N/m.
Arm falcon_arm(const FalconConfig& config);
MotorFlags falcon_flags();

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/arm.h"

namespace haptic {

/// A device that gives its handle's pose and takes a wrench, behind a program that links its
/// vendor's SDK (docs/your-own-device.md). It speaks the line of six motors; its six counts are the
/// pose itself and its six numbers the wrench, so that these functions only convert units:
///   counts    p_BH [µm], then the rotation vector of q_BH [10 µrad]
///   numbers   force on the hand in B [5 mN], then torque about the handle's origin [0.1 mN·m]
/// A "joint angle" is thus one of p_BH [m] and the rotation vector [rad], and the force that the
/// line has room for is ±30 N and ±0.6 N·m on each axis.
const Arm& own_device_arm();

}  // namespace haptic

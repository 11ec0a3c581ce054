// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/arm.h"

namespace haptic {

/// A Polhem with its Teensy firmware, which speaks the line of the WoodenHaptics: three motors with
/// encoders at its linkage, three encoders in the gimbal of its handle, which has no motors. It
/// takes no torque: that is dropped before the limits, and none is missing. Source as of
/// PolhemLinkage; the signs of the gimbal are those of getRot in hfab_api.cpp.
///
/// Joint angles (A, B, C; D, E, F) [rad]: of the linkage; of the gimbal, which turns the handle
/// against the forearm about its x (along the forearm), y and x again:
///   q_BH = R(z, A) R(y, −λ) R(x, D) R(y, E) R(x, F).
/// Its solution has −π ≤ E ≤ 0, and D is zero where the handle is in line with the forearm. Motors
/// do nothing where the linkage is singular.
const Arm& polhem_arm();

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/woodenhaptics/kinematics.h"

namespace haptic::test {

/// The tip of a WoodenHaptics whose encoders count so, in B.
inline Vec3 tip_at(const MotorCounts& counts) {
  return woodenhaptics_arm().pose(woodenhaptics_arm().angles(counts)).p;
}

}  // namespace haptic::test

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/woodenhaptics_kinematics.h"

namespace haptic {

/// What haptic-emulator can be told to do (send_order).
enum class EmulatorFault : int {
  kJumpOnce = 1,  // one answer is off by kJumpCounts
  kJump = 2,      // every answer is, until told otherwise
  kHealthy = 3,
};

/// Half a turn of the first body, and the other two level: from the middle of the workspace to the
/// other side of the foot, arm stretched. That is 0.67 m, the farthest that this arm can be away.
inline constexpr MotorCounts kJumpCounts{16000, -4600, -3540};

}  // namespace haptic

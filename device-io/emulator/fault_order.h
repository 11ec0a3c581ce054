// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

#include "device-io/woodenhaptics/kinematics.h"

namespace haptic {

/// What haptic-emulator can be told to do (send_order).
enum class EmulatorFault : int {
  kJumpOnce = 1,  // one answer is off by kJumpCounts
  kJump = 2,      // every answer is, until told otherwise
  kHealthy = 3,
  kFrozen = 4,    // the same valid answer for ever, whatever is asked; the motors obey
  kOldFirst = 5,  // each answer comes behind one that is kLateAnswers old
  kDelayed = 6,   // each answer is the one to the question kLateAnswers before
  kNoise = 7,     // kNoiseCounts of noise on the second encoder
};

/// A second at 1 kHz.
inline constexpr size_t kLateAnswers = 1000;
inline constexpr int32_t kNoiseCounts = 60;  // at most, each value as likely: 3 mm at the tip

/// Half a turn of the first body, and the other two level: from the middle of the workspace to the
/// other side of the foot, arm stretched. That is 0.67 m, the farthest that this arm can be away.
inline constexpr MotorCounts kJumpCounts{16000, -4600, -3540};

}  // namespace haptic

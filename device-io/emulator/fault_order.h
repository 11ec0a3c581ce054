// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

#include "device-io/sensing/motor_counts.h"

namespace haptic {

/// How an emulated device deviates from an honest one; the numbered ones are orders to
/// haptic-emulator (send_order). No device knows all of these.
enum class EmulatorFault : int {
  kJumpOnce = 1,  // one answer is off by kJumpCounts
  kJump = 2,      // every answer is, until the next order
  kHealthy = 3,
  kFrozen = 4,        // always the same valid answer; the motors obey
  kOldFirst = 5,      // each answer is preceded by one that is kLateAnswers old
  kDelayed = 6,       // each answer belongs to the question kLateAnswers before
  kNoise = 7,         // kNoiseCounts of noise on the second encoder
  kTurnJumpOnce = 8,  // one answer is off by kTurnJumpCounts, of a device with six motors
  kTurnJump = 9,      // every answer is, until the next order
  kTurnNoise = 10,    // kNoiseCounts of noise on the last encoder of six: 11 mrad
  kGrasp = 11,        // no fault: the hand takes what lies below it (--grasp)
  kLetGo = 12,        // it lets go of that and goes back to its strokes
  kFrozenCounts,      // the same counts, in answers that are right otherwise
  kJumps,             // the counter of its reports goes anywhere
  kFlipped,           // one encoder or axis counts backwards
  kSlipped,           // one encoder is off by 3000 counts
  kOverdone,          // all axes read 32767
  kSilent,            // no answer
  kHalves,            // each answer comes in two packets
  kLoses,             // one byte in a hundred or one report in ten is lost
};

/// After kGrasp, until the hand is where it takes the thing, by 1 % [ns].
inline constexpr int64_t kReachNs = 250'000'000;

/// [answers], one second at 1 kHz
inline constexpr size_t kLateAnswers = 1000;
inline constexpr int32_t kNoiseCounts = 60;  // largest deviation, uniform: 3 mm at the tip

/// Half a turn of the first body, with the other two level: the tip jumps 0.67 m, the largest
/// distance of this arm, from the middle of the workspace to the far side of the foot.
inline constexpr MotorCounts kJumpCounts{16000, -4600, -3540};

/// One radian of the handle about its own z, by the last motor of the wrist.
inline constexpr MotorCounts kTurnJumpCounts{0, 0, 0, 0, 0, 5215};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic::test {

/// How an emulated device deviates from an honest one. None of them knows all of these.
enum class Lie {
  kHealthy,
  kFrozen,        // the same answer for ever, in time
  kFrozenCounts,  // the same counts, in answers that are right otherwise
  kDelayed,       // each answer is one of many answers ago
  kOldFirst,      // before each answer an old one
  kJumps,         // the counter of its reports goes anywhere
  kNoise,         // one encoder or axis jumps about by some ten counts
  kTurnNoise,     // the last encoder of a wrist does
  kFlipped,       // one encoder or axis counts backwards
  kSlipped,       // one encoder is off by 3000 counts
  kOverdone,      // all axes read 32767
  kSilent,        // no answer
  kHalves,        // each answer comes in two packets
  kLoses,         // one byte in a hundred or one report in ten is lost
};

}  // namespace haptic::test

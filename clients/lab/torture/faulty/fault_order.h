// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

/// Faults that haptic-faulty-contact can be ordered to inject (send_order). It starts healthy.
enum class ContactFault : int {
  kHealthy = 1,
  kNaN = 2,       // in every number of the planes of one answer
  kInfinity = 3,  // likewise
  kTenTimes = 4,  // every answer takes ten periods of the servo, until the next order
  kThousandTimes = 5,
  kLies = 6,  // finite but wrong planes, different in each answer, until the next order
};

/// Faults that haptic-faulty-giver can be ordered to inject. It starts healthy.
enum class GiverFault : int {
  kHealthy = 1,
  kNaN = 2,        // in each number in turn
  kHuge = 3,       // 1e300, likewise
  kUnturned = 4,   // quaternions that are none
  kBackwards = 5,  // its frames, its instants and the servo's ticks go back
  kFlood = 6,      // four frames a millisecond, of which half are valid
  kGarbage = 7,    // random bytes all over its segment, whose rings and header are spoilt for good
};

}  // namespace haptic

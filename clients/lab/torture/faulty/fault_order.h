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

}  // namespace haptic

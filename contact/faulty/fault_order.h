// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace haptic {

/// What haptic-faulty-contact can be told to do (send_order). It starts healthy.
enum class ContactFault : int {
  kHealthy = 1,
  kNaN = 2,       // in every number of the planes of one answer
  kInfinity = 3,  // the same
  kTenTimes = 4,  // every answer takes ten periods of the servo, until told otherwise
  kThousandTimes = 5,
  kLies = 6,  // finite planes that are not there, another lie in each answer, until told otherwise
};

}  // namespace haptic

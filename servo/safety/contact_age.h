// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/age.h"

namespace haptic {

struct ContactWeight {
  double weight = 0;   // of the contacts in the force, 0 to 1
  uint32_t flags = 0;  // ServoFlag: holding, fading, stale, reopening, no set
};

/// How the age of the contacts scales the force at time t_ns (proto/wire/age.h). It counts from the
/// ServoFrame that a set answers; the hold is 20 to 100 ms.
ContactWeight weigh_contacts(Age& age, const Arrival& arrival, int64_t t_ns, double dt);

}  // namespace haptic

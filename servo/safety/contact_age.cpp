// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/contact_age.h"

#include "proto/math/assert.h"
#include "proto/wire/wire.h"

namespace haptic {
namespace {

uint32_t flag_of(AgeState state) {
  switch (state) {
    case AgeState::kNone:
      return kServoNoContactSet;
    case AgeState::kFresh:
      return 0;
    case AgeState::kHolding:
      return kServoHolding;
    case AgeState::kFading:
      return kServoFading;
    case AgeState::kClosed:
      return kServoStale;
  }
  HAPTIC_ASSERT(false);
  return 0;
}

}  // namespace

ContactWeight weigh_contacts(Age& age, const Arrival& arrival, int64_t t_ns, double dt) {
  const AgedWeight aged = weigh(age, arrival, t_ns, dt);
  return {aged.weight, flag_of(aged.state) | (aged.rises ? uint32_t{kServoReopening} : 0)};
}

}  // namespace haptic

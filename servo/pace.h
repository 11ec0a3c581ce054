// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/tick.h"

namespace haptic {

/// Returns ServoFlag bits of the processes that do not keep up. They are judged once a second and
/// reported for the next second.
///   servo:    more than 1 % of its ticks were skipped
///   contact:  in more than 1 % of its ticks contacts were so old that they held or faded
///   sim:      it published less than 90 % of the frames of its rate, but some
/// `age_flags`: of the contacts in this tick (weigh_contacts); `sim_period` [s].
uint32_t keep_pace(Pace& pace, const ServoInput& input, uint32_t age_flags, double sim_period);

}  // namespace haptic

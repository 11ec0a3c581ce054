// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/model.h"
#include "servo/tick.h"

namespace haptic {

/// One tick: tool pose → carried contacts → proxy of the solver that goes with the detector of the
/// contacts → coupling wrench → device wrench → safety. Always returns a frame with a finite
/// wrench; what went wrong is in its flags. busy_ns is the shell's.
ServoFrame servo_step(const ServoModel& model, ServoState& state, const ServoInput& input);

}  // namespace haptic

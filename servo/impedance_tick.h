// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/tick.h"

namespace haptic {

/// The rest of a tick of a device that measures a pose and is told a wrench: tool → how the scene
/// answers it → wrench at the handle → safety →
/// what holds up the arm.
Outcome impedance_tick(const ServoModel& model, ServoState& state, const ServoInput& input,
                       const TickStart& start);

}  // namespace haptic

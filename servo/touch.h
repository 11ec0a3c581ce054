// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/tick.h"

namespace haptic {

/// Finds the answer of the scene to the tool. The objects are where the newest scene says, carried
/// on by twist and pushes, else where contact saw them. The proxy is found by the solver that goes
/// with the detector of the contacts; it begins with nothing of another's. `weight`: of the
/// contacts, by their age.
Touch touch_of(const ServoModel& model, ServoState& state, const ServoInput& input,
               const Tool& tool, const Coupling& coupling, double weight);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/tick.h"

namespace haptic {

/// The rest of a tick with a device that measures the hand's wrench and is commanded a pose:
/// measured wrench → safety → free step of the virtual body → tool → proxy → commanded pose.
///
/// The safety of a wanted wrench (make_safe) is that of the measured one: what it would not let
/// through to the hand does not move the body either. Then the body steps freely
/// (virtual_body.h), no faster than the limits of velocity and no more than keeps it passive
/// (energy_ledger.h). A proxy that is led by a spring as stiff as M/dt² is the pose that a body of
/// mass M has after the step if nothing but the contacts constrains it, by Gauss' principle of
/// least constraint; so for a point and for a rigid tool the body takes the pose of the proxy. That
/// of a point does not enter an object, and is commanded; of a rigid tool the pose is commanded
/// that contact has proven free, a tick later, for the planes around a turning body hold to first
/// order only. A soft body may enter objects; the wrench of its coupling acts on the virtual body.
/// The scene may stop the body at once, but pushes it with no more than max_force and max_torque.
///
/// Where nothing may be rendered the body brakes to rest with max_force and max_torque, on the
/// right side of what is known still; and it goes nowhere that contact has not looked at
/// (seen_space.h), so that contacts that do not come stop it.
Outcome admittance_tick(const ServoModel& model, ServoState& state, const ServoInput& input,
                        const TickStart& start);

}  // namespace haptic

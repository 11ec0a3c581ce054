// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/render.h"

namespace haptic {

/// The coupling in force, with the bounds of the session.
VirtualCoupling coupling_in_force(const ServoModel& model, const RenderQuestion& question);

/// The tool that contact has baked, else the session's.
RigidBody tool_in_force(const ServoModel& model, const ContactSet& contacts);

/// Rate-limits the step of the force since the last tick (servo/render/felt_step.h). What is
/// added comes from the object that carried the tool then.
void limit_step(const ServoModel& model, const RenderQuestion& question, FeltStep& state,
                BodySolution& solution);

/// What a solver of a body came to, and the opposite of what the objects pushed it with, which they
/// are pushed with, about their origins.
Rendered rendered_body(const RenderQuestion& question, const BodySolution& solution);

}  // namespace haptic

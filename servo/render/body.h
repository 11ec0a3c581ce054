// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/felt_step.h"
#include "servo/render/render.h"

namespace haptic {

/// The tool that contact has baked, else the session's.
const ToolBody& tool_in_force(const ServoModel& model, const ContactSet& contacts);

/// The tick as a solver of a body is asked about it.
BodyTick body_tick(const ServoModel& model, const RenderQuestion& question);

/// What a solver of a body came to, and the opposite of what the objects pushed it with, which they
/// are pushed with, about their origins.
Rendered rendered_body(const RenderQuestion& question, const BodySolution& solution);

/// The same, with the step of the force since the last tick rate-limited
/// (servo/render/felt_step.h). What is added comes from the object that carried the tool
/// then.
Rendered rendered_body(const ServoModel& model, const RenderQuestion& question,
                       BodySolution solution, FeltStep& continuity);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/felt_step.h"
#include "servo/render/render.h"
#include "servo/solve/body/god_object6.h"

/// The solvers of a tool that never enters an object: the contacts' verified pose at this tick, the
/// proxy, the coupling's wrench.
namespace haptic {

struct GodObject6Solver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  GodObject6State state;
  FeltStep continuity;
};

struct Constrained6Solver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  Constrained6State state;
  FeltStep continuity;
};

}  // namespace haptic

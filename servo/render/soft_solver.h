// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/render/felt_step.h"
#include "servo/render/render.h"

namespace haptic {

/// The solver of a tool that may enter objects, with six degrees of freedom: soft contacts at this
/// tick, the proxy of the session's solver, the coupling's wrench.
struct SoftProxySolver {
  Rendered render(const ServoModel& model, const RenderQuestion& question, ContactSolvers& solvers);

  SoftProxyState state;
  FeltStep continuity;
};

}  // namespace haptic

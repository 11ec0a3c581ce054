// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/rigid_solver.h"

#include "servo/render/body.h"

namespace haptic {

Rendered GodObject6Solver::render(const ServoModel& model, const RenderQuestion& question,
                                  ContactSolvers& solvers) {
  const BodyTick tick = body_tick(model, question);
  return rendered_body(model, question,
                       solve_god_object6(model.materials, state, solvers.coulomb, tick),
                       continuity);
}

Rendered Constrained6Solver::render(const ServoModel& model, const RenderQuestion& question,
                                    ContactSolvers& solvers) {
  const BodyTick tick = body_tick(model, question);
  return rendered_body(
      model, question,
      solve_constrained6(model.constrained6, model.materials, state, solvers, tick), continuity);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
// The renderers of a tool that never enters an object: the contacts' verified pose at this tick,
// the proxy, the coupling's wrench.
#include "servo/render/body.h"
#include "servo/solve/body/god_object6.h"

namespace haptic {
Rendered render_god_object6(const ServoModel& model, const RenderQuestion& question,
                            RenderState& state) {
  BodySolution solution =
      solve_god_object6(model.materials, state.kept.keep<GodObject6State>(),
                        state.contact_solvers.coulomb, body_tick(model, question));
  limit_step(model, question, state.continuity, solution);
  return rendered_body(question, solution);
}

Rendered render_constrained6(const ServoModel& model, const RenderQuestion& question,
                             RenderState& state) {
  BodySolution solution =
      solve_constrained6(model.constrained6, model.materials, state.kept.keep<Constrained6State>(),
                         state.contact_solvers, body_tick(model, question));
  limit_step(model, question, state.continuity, solution);
  return rendered_body(question, solution);
}

}  // namespace haptic

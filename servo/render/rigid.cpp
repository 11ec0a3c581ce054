// SPDX-License-Identifier: GPL-3.0-or-later
// The renderers of a tool that never enters an object: the contacts' verified pose at this tick,
// the proxy, the coupling's wrench.
#include "proto/math/assert.h"
#include "servo/render/body.h"
#include "servo/solve/body/god_object6.h"

namespace haptic {
namespace {

/// What the session says, with the coupling in force and the tool that contact has baked.
RigidProxyModel rigid_proxy_model(const ServoModel& model, const RenderQuestion& question) {
  RigidProxyModel proxy;
  proxy.coupling = coupling_in_force(model, question);
  proxy.tool = tool_in_force(model, question.contacts);
  proxy.materials = model.virtual_proxy.materials;
  proxy.images = model.virtual_proxy.images;
  proxy.solver = model.rigid_solver;
  return proxy;
}

RigidProxyTick tick_of(const ServoModel& model, const RenderQuestion& question) {
  HAPTIC_ASSERT(model.dt > 0);
  return {question.scene, {question.X_WT, question.V_WT}, &question.contacts, model.dt};
}

}  // namespace

Rendered render_god_object6(const ServoModel& model, const RenderQuestion& question,
                            RenderState& state) {
  BodySolution solution =
      solve_god_object6(rigid_proxy_model(model, question), state.kept.keep<GodObject6State>(),
                        state.contact_solvers.coulomb, tick_of(model, question));
  limit_step(model, question, state.continuity, solution);
  return rendered_body(question, solution);
}

Rendered render_constrained6(const ServoModel& model, const RenderQuestion& question,
                             RenderState& state) {
  BodySolution solution =
      solve_constrained6(rigid_proxy_model(model, question), state.kept.keep<Constrained6State>(),
                         state.contact_solvers, tick_of(model, question));
  limit_step(model, question, state.continuity, solution);
  return rendered_body(question, solution);
}

}  // namespace haptic

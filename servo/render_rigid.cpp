// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/math/assert.h"
#include "proto/wire/renderer.h"
#include "servo/rendered.h"

namespace haptic {
namespace {

/// What the session says, with the coupling in force and the tool that contact has baked.
RigidProxyModel proxy_model(const ServoModel& model, const ServoState& state,
                            const ContactSet& contacts) {
  RigidProxyModel proxy;
  proxy.coupling = coupling_in_force(model, state);
  proxy.tool = tool_in_force(model, contacts);
  proxy.materials = model.virtual_proxy.materials;
  proxy.images = model.virtual_proxy.images;
  proxy.solver = model.rigid_solver;
  return proxy;
}

BodySolution solve(const RigidProxyModel& model, ServoState& state, Solver solver,
                   const RigidProxyTick& tick) {
  if (solver == Solver::kGodObject6) {
    return solve_god_object6(model, keep<GodObject6State>(state.proxy),
                             state.contact_solvers.coulomb, tick);
  }
  return solve_constrained6(model, keep<Constrained6State>(state.proxy), state.contact_solvers,
                            tick);
}

}  // namespace

Rendered render_rigid(const ServoModel& model, ServoState& state, const ServoInput& input,
                      const TickScene& scene, const ServoFrame& frame) {
  HAPTIC_ASSERT(input.contacts != nullptr && model.dt > 0);
  const ContactSet& contacts = *input.contacts;
  const RigidProxyTick tick{scene, {frame.X_WT, frame.V_WT}, &contacts, model.dt};
  const auto renderer = static_cast<Renderer>(contacts.renderer);
  BodySolution solution =
      solve(proxy_model(model, state, contacts), state, row_of(renderer).solver, tick);
  limit_step(model, state, scene, frame.X_WT, solution);
  return rendered_body(model, state, scene, solution);
}

}  // namespace haptic

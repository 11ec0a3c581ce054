// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/math/assert.h"
#include "servo/rendered.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kMostTicks = 20;  // that an answer's look-ahead is shared among

/// What the session says, with the coupling in force and the tool that contact has baked.
SoftProxyModel proxy_model(const ServoModel& model, const ServoState& state,
                           const ContactSet& contacts) {
  SoftProxyModel proxy = model.body;
  const auto renderer = static_cast<Renderer>(contacts.renderer);
  proxy.solver = solver_of(model.proxy, renderer);
  proxy.coupling = coupling_in_force(model, state);
  proxy.tool = tool_in_force(model, contacts);
  // triangles that meet have no band to leave
  if (renderer == Renderer::kDirect6) proxy.max_travel = 0;
  return proxy;
}

/// Bound on how far a point of the hand's tool has moved in this tick [m].
double hand_travel(const RigidBody& tool, const ServoState& state, const Pose& X_WT) {
  if (!state.started) return 0;
  const Pose before = motion_of_centre(tool, {state.X_WT, {}}).X_WC;
  const Pose now = motion_of_centre(tool, {X_WT, {}}).X_WC;
  return largest_travel(way_between(before, now), tool.radius);
}

/// Pushes the opposite of what they push the proxy with into the objects, about their origins.
void add_impulses(const BodySolution& solution, const TickScene& scene, double dt,
                  std::array<Wrench, kMaxObjects>& impulse_W) {
  for (size_t i = 0; i < kMaxObjects; ++i) {
    if (solution.push_W[i] == Wrench{}) continue;
    const Vec3 arm_W = solution.proxy.X_WT.p - scene.X_WO[i].p;
    impulse_W[i] = impulse_W[i] + -dt * shift(solution.push_W[i], arm_W);
  }
}

/// The object that pushes the proxy hardest; kNoObject if none does.
uint32_t carrier_of(const BodySolution& solution) {
  double hardest = 0;
  uint32_t carrier = kNoObject;
  for (uint32_t i = 0; i < kMaxObjects; ++i) {
    const double push = norm(solution.push_W[i].f);
    if (push > hardest) hardest = push, carrier = i;
  }
  return carrier;
}

}  // namespace

void limit_step(const ServoModel& model, ServoState& state, const TickScene& scene,
                const Pose& X_WT, BodySolution& solution) {
  // contacts that do not count any more, or not yet, are not held either
  if (!solution.finite || !(scene.weight > 0)) {
    state.continuity = {};
    return;
  }
  const uint32_t giver = state.continuity.carrier;
  const Coupling& k = state.coupling;
  const Wrench F_W = limit_force_step(state.continuity,
                                      {solution.F_hand_W, X_WT, carrier_of(solution),
                                       k.translational_stiffness, k.rotational_stiffness, model.dt},
                                      scene.X_WO);
  const Wrench added_W = F_W + -solution.F_hand_W;
  if (giver < kMaxObjects) solution.push_W[giver] = solution.push_W[giver] + added_W;
  solution.F_hand_W = F_W;
}

VirtualCoupling coupling_in_force(const ServoModel& model, const ServoState& state) {
  VirtualCoupling coupling = model.body.coupling;
  coupling.translational_stiffness = state.coupling.translational_stiffness;
  coupling.translational_damping = state.coupling.translational_damping;
  coupling.rotational_stiffness = state.coupling.rotational_stiffness;
  coupling.rotational_damping = state.coupling.rotational_damping;
  return coupling;
}

RigidBody tool_in_force(const ServoModel& model, const ContactSet& contacts) {
  return contacts.tool.mass > 0 ? rigid_body_of(contacts.tool) : model.body.tool;
}

Rendered rendered_body(const ServoModel& model, const ServoState& state, const TickScene& scene,
                       const BodySolution& solution) {
  Rendered out;
  out.X_WP = solution.proxy.X_WT;
  out.V_WP = solution.proxy.V_WT;
  out.F_W = solution.F_hand_W;
  if (const uint32_t carrier = carrier_of(solution); carrier != kNoObject) {
    const Vec3 arm_W = solution.proxy.X_WT.p - scene.X_WO[carrier].p;
    out.surface_W = velocity_at(scene.V_WO[carrier], arm_W);
  }
  out.held_back_W = solution.held_back_W;
  out.n_pushing = solution.n_pushing;
  out.finite = solution.finite;
  out.converged = solution.converged;
  out.object_impulse_W = state.object_impulse_W;
  add_impulses(solution, scene, model.dt, out.object_impulse_W);
  return out;
}

Rendered render_body(const ServoModel& model, ServoState& state, const ServoInput& input,
                     const TickScene& scene, const ServoFrame& frame) {
  HAPTIC_ASSERT(input.contacts != nullptr && model.dt > 0);
  const ContactSet& contacts = *input.contacts;
  const SoftProxyTick tick{scene, {frame.X_WT, frame.V_WT}, &contacts, model.dt};
  SoftProxyModel proxy = proxy_model(model, state, contacts);
  if (proxy.max_travel > 0) {
    // what contact has seen ahead is for all the ticks since
    const double age = static_cast<double>(input.t_ns - contacts.answers_t_ns) * 1e-9 / model.dt;
    // of contacts that are not rendered any more nothing is passed unseen: the proxy catches up
    scene.weight > 0 ? proxy.max_travel /= std::clamp(age, 1.0, kMostTicks)
                     : proxy.max_travel += hand_travel(proxy.tool, state, frame.X_WT);
  }
  BodySolution solution = solve_soft_proxy(proxy, keep<SoftProxyState>(state.proxy), tick);
  // without a coupling the hand feels the contacts' own stiffness, which no bound is known of
  if (proxy.solver != SoftSolver::kDirect) {
    limit_step(model, state, scene, frame.X_WT, solution);
  }
  return rendered_body(model, state, scene, solution);
}

}  // namespace haptic

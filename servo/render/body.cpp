// SPDX-License-Identifier: GPL-3.0-or-later
// The renderers of a tool that may enter objects, with six degrees of freedom: soft contacts at
// this tick, the proxy of the session's solver, the coupling's wrench.
#include "servo/render/body.h"

#include <algorithm>

#include "proto/config/renderer_needs.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kMostTicks = 20;  // that an answer's look-ahead is shared among

/// Bound on how far a point of the hand's tool has moved in this tick [m].
double hand_travel(const ToolBody& tool, const RenderQuestion& question) {
  if (!question.X_WT_before) return 0;
  const Pose before = motion_of_centre(tool, {*question.X_WT_before, {}}).X_WC;
  const Pose now = motion_of_centre(tool, {question.X_WT, {}}).X_WC;
  return largest_travel(way_between(before, now), tool.radius);
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

void limit_step(const ServoModel& model, const RenderQuestion& question, ForceContinuity& state,
                BodySolution& solution) {
  // contacts that do not count any more, or not yet, are not held either
  if (!solution.finite || !(question.scene.weight > 0)) {
    state = {};
    return;
  }
  const uint32_t giver = state.carrier;
  const Coupling& k = question.coupling;
  const Wrench F_W = limit_force_step(state,
                                      {solution.F_hand_W, question.X_WT, carrier_of(solution),
                                       k.translational_stiffness, k.rotational_stiffness, model.dt},
                                      question.scene.X_WO);
  const Wrench added_W = F_W + -solution.F_hand_W;
  if (giver < kMaxObjects) solution.push_W[giver] = solution.push_W[giver] + added_W;
  solution.F_hand_W = F_W;
}

const ToolBody& tool_in_force(const ServoModel& model, const ContactSet& contacts) {
  return contacts.tool.mass > 0 ? contacts.tool : model.tool;
}

BodyTick body_tick(const ServoModel& model, const RenderQuestion& question) {
  HAPTIC_ASSERT(model.dt > 0);
  return {question.scene, {question.X_WT, question.V_WT},          &question.contacts,
          model.dt,       tool_in_force(model, question.contacts), question.coupling};
}

Rendered rendered_body(const RenderQuestion& question, const BodySolution& solution) {
  Rendered out;
  out.X_WP = solution.proxy.X_WT;
  out.V_WP = solution.proxy.V_WT;
  out.F_W = solution.F_hand_W;
  if (const uint32_t carrier = carrier_of(solution); carrier != kNoObject) {
    const Vec3 arm_W = solution.proxy.X_WT.p - question.scene.X_WO[carrier].p;
    out.surface_W = velocity_at(question.scene.V_WO[carrier], arm_W);
    out.surface_turning_W = question.scene.V_WO[carrier].w;
  }
  out.held_back_W = solution.held_back_W;
  out.n_pushing = solution.n_pushing;
  out.finite = solution.finite;
  out.converged = solution.converged;
  std::copy(solution.push_W.begin(), solution.push_W.end(), out.push_W.begin());
  return out;
}

Rendered render_soft_proxy(const ServoModel& model, const RenderQuestion& question,
                           RenderState& state) {
  const BodyTick tick = body_tick(model, question);
  const auto renderer = static_cast<Renderer>(question.contacts.renderer);
  SoftProxyModel proxy = model.soft;
  proxy.solver = question.soft_solver.value_or(solver_of(model.proxy, renderer));
  // triangles that meet have no band to leave
  if (!row_of(renderer).has_maps) proxy.max_travel = 0;
  if (proxy.max_travel > 0) {
    // what contact has seen ahead is for all the ticks since
    const auto since_ns = static_cast<double>(question.t_ns - question.contacts.answers_t_ns);
    const double age = since_ns * 1e-9 / model.dt;
    // of contacts that are not rendered any more nothing is passed unseen: the proxy catches up
    tick.weight > 0 ? proxy.max_travel /= std::clamp(age, 1.0, kMostTicks)
                    : proxy.max_travel += hand_travel(tick.tool, question);
  }
  BodySolution solution = solve_soft_proxy(proxy, state.kept.keep<SoftProxyState>(), tick);
  // without a coupling the hand feels the contacts' own stiffness, which no bound is known of
  if (proxy.solver == SoftSolver::kDirect) {
    state.continuity = {};
  } else {
    limit_step(model, question, state.continuity, solution);
  }
  return rendered_body(question, solution);
}

}  // namespace haptic

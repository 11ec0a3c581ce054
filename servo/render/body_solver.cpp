// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/body_solver.h"

#include <algorithm>

#include "proto/config/renderer_needs.h"
#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"

namespace haptic {
namespace {

constexpr double kMostTicks = 20;         // that an answer's look-ahead is shared among
constexpr double kLeastStiffness = 1e-6;  // that a metric can be made of [N/m], [N·m/rad]

Pose carrier_pose(uint32_t carrier, std::span<const Pose> X_WO) {
  return carrier < X_WO.size() ? X_WO[carrier] : Pose{};
}

Wrench rotated(const Quat& q, const Wrench& F) {
  return {rotate(q, F.f), rotate(q, F.t)};
}

/// The tick as a solver of a body is asked about it.
BodyTick body_tick(const ServoModel& model, const RenderQuestion& question) {
  HAPTIC_ASSERT(model.dt > 0);
  return {question.scene, {question.X_WT, question.V_WT},          &question.contacts,
          model.dt,       tool_in_force(model, question.contacts), question.coupling};
}

/// The object that pushes the proxy hardest; kNoBody if none does.
uint32_t carrier_of(const BodySolution& solution, size_t n_bodies) {
  double hardest = 0;
  uint32_t carrier = kNoBody;
  for (uint32_t i = 0; i < n_bodies; ++i) {
    const double push = norm(solution.push_W[i].f);
    if (push > hardest) hardest = push, carrier = i;
  }
  return carrier;
}

/// Limits the step of the wrench since the last tick. What is added comes from the object that
/// carried the tool then. Contacts that do not count any more, or not yet, are not held either, nor
/// what clients' planes push with, which is cut to what may be felt of it later (servo/given).
void limit_step(const ServoModel& model, const RenderQuestion& question, BodySolution& solution,
                FeltStep& felt) {
  if (!solution.finite || !(question.scene.weight > 0)) {
    felt = {};
    return;
  }
  const uint32_t giver = felt.carrier;
  const Coupling& k = question.coupling;
  const size_t n_objects = question.scene.n_objects();
  Wrench planes_W;
  for (size_t i = n_objects; i < solution.push_W.size(); ++i) {
    planes_W = planes_W + solution.push_W[i];
  }
  const Wrench wanted_W = solution.F_hand_W + -planes_W;
  const Wrench F_W = limit_felt_step(felt,
                                     {wanted_W, question.X_WT, carrier_of(solution, n_objects),
                                      k.translational_stiffness, k.rotational_stiffness, model.dt},
                                     {question.scene.X_WO.data(), n_objects});
  if (giver < n_objects) solution.push_W[giver] = solution.push_W[giver] + F_W + -wanted_W;
  solution.F_hand_W = F_W + planes_W;
}

/// The answer of a solver as all renderers give it. The objects are pushed with the opposite of
/// what they push the proxy with.
Rendered rendered_body(const RenderQuestion& question, const BodySolution& solution) {
  Rendered out;
  out.X_WP = solution.proxy.X_WT;
  out.V_WP = solution.proxy.V_WT;
  out.F_W = solution.F_hand_W;
  if (const uint32_t carrier = carrier_of(solution, solution.push_W.size()); carrier != kNoBody) {
    const Vec3 arm_W = solution.proxy.X_WT.p - question.scene.X_WO[carrier].p;
    out.surface_W = velocity_at(question.scene.V_WO[carrier], arm_W);
    out.surface_turning_W = question.scene.V_WO[carrier].w;
  }
  out.held_back_W = solution.held_back_W;
  out.n_pushing = solution.n_pushing;
  out.finite = solution.finite;
  out.converged = solution.converged;
  out.push_W = solution.push_W;
  return out;
}

/// Bound on how far a point of the hand's tool has moved in this tick [m].
double hand_travel(const ToolBody& tool, const RenderQuestion& question) {
  if (!question.X_WT_before) return 0;
  const Pose before = motion_of_centre(tool, {*question.X_WT_before, {}}).X_WC;
  const Pose now = motion_of_centre(tool, {question.X_WT, {}}).X_WC;
  return largest_travel(way_between(before, now), tool.radius);
}

}  // namespace

Wrench limit_felt_step(FeltStep& state, const WantedForce& step, std::span<const Pose> X_WO) {
  HAPTIC_ASSERT(step.dt > 0);
  const double k_T = std::max(step.translational, kLeastStiffness);
  const double k_R = std::max(step.rotational, kLeastStiffness);
  Wrench F_W = step.F_W;
  if (state.started) {
    const Pose X_WC = carrier_pose(state.carrier, X_WO);
    const Wrench last_W = rotated(X_WC.q, state.F_C);
    const Twist hand = way_between(X_WC * state.X_CT, step.X_WT);
    const double most = k_T * spring_length(hand, k_T, k_R) + kMostForceRate * step.dt;
    const double size = spring_force(F_W + -last_W, k_T, k_R);
    if (size > most) F_W = last_W + most / size * (F_W + -last_W);
  }
  const Pose X_CW = inverse(carrier_pose(step.carrier, X_WO));
  state = {true, step.carrier, X_CW * step.X_WT, rotated(X_CW.q, F_W)};
  return F_W;
}

const ToolBody& tool_in_force(const ServoModel& model, const ContactSet& contacts) {
  return contacts.tool.mass > 0 ? contacts.tool : model.tool;
}

Rendered GodObject6Solver::render(const ServoModel& model, const RenderQuestion& question,
                                  ContactSolvers& solvers) {
  BodySolution solution =
      solve_god_object6(model.materials, state, solvers.coulomb, body_tick(model, question));
  limit_step(model, question, solution, felt);
  return rendered_body(question, solution);
}

Rendered Constrained6Solver::render(const ServoModel& model, const RenderQuestion& question,
                                    ContactSolvers& solvers) {
  BodySolution solution = solve_constrained6(model.constrained6, model.materials, state, solvers,
                                             body_tick(model, question));
  limit_step(model, question, solution, felt);
  return rendered_body(question, solution);
}

Rendered SoftProxySolver::render(const ServoModel& model, const RenderQuestion& question,
                                 ContactSolvers&) {
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
  BodySolution solution = solve_soft_proxy(proxy, state, tick);
  // without a coupling the hand feels the contacts' own stiffness, which no bound is known of
  if (proxy.solver == SoftSolver::kDirect) {
    felt = {};
  } else {
    limit_step(model, question, solution, felt);
  }
  return rendered_body(question, solution);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/render/soft_solver.h"

#include <algorithm>

#include "proto/config/renderer_needs.h"
#include "servo/render/body.h"

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

}  // namespace

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
  const BodySolution solution = solve_soft_proxy(proxy, state, tick);
  if (proxy.solver != SoftSolver::kDirect) {
    return rendered_body(model, question, solution, continuity);
  }
  // without a coupling the hand feels the contacts' own stiffness, which no bound is known of
  continuity = {};
  return rendered_body(question, solution);
}

}  // namespace haptic

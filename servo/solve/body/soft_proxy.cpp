// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/soft_proxy.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "servo/solve/body/free_space.h"

namespace haptic {
namespace {

/// Sums the pushes on each object.
void note_soft_pushes(const SoftContacts& contacts, const ToolBody& tool, const BodyMotion& body,
                      BodySolution& out) {
  const Vec3 arm_W = body.X_WC.p - out.proxy.X_WT.p;
  for (size_t i = 0; i < contacts.size; ++i) {
    const std::optional<ContactRow> row = pushing_row(contacts.contacts[i], body);
    if (!row) continue;
    ++out.n_pushing;
    Wrench& sum = out.push_W[contacts.contacts[i].object];
    sum = sum + shift(row->push * row->unit, arm_W);
  }
  if (!contacts.has_rest) return;
  Wrench& sum = out.push_W[contacts.rest_object];
  sum = sum + shift(rest_wrench(contacts, tool, body.X_WC, body).F_W, arm_W);
}

/// Wrench of the contacts at the hand's pose, about the tool's origin.
Wrench direct_wrench(const BodyTick& tick, const SoftContacts& contacts) {
  const BodyMotion body = motion_of_centre(tick.tool, tick.hand);
  const Wrench F = soft_contact_wrench(contacts.view(), body).F_W +
                   rest_wrench(contacts, tick.tool, body.X_WC, body).F_W +
                   brake_wrench(contacts, body).F_W;
  return shift(F, body.X_WC.p - tick.hand.X_WT.p);
}

void step_dynamics(const SoftProxyModel& model, const SoftContacts& contacts, const BodyTick& tick,
                   const FreeSpace& space, BodySolution& out) {
  const BodyMotion body = motion_of_centre(tick.tool, out.proxy);
  double max_travel = model.max_travel;
  if (max_travel > 0) max_travel += std::max(space.left_at(body.X_WC), 0.0);
  BodyWrench smooth = coupling_wrench(tick.coupling, tick.tool, tick.hand, body);
  const BodyWrench brake = brake_wrench(contacts, body);
  smooth.F_W = smooth.F_W + brake.F_W;
  smooth.by_twist += brake.by_twist;
  const auto step = [&] {
    return penalty_dynamics_step(tick.tool, body, smooth, contacts.view(), model.integrator,
                                 {tick.dt, max_travel});
  };
  PenaltyResult next = step();
  if (contacts.has_rest && next.is_solved) {
    // the push of the springs at the end of the step bounds the rest
    const BodyWrench rest = rest_wrench(contacts, tick.tool, body.X_WC, next.body);
    smooth.F_W = smooth.F_W + rest.F_W;
    smooth.by_motion += rest.by_motion;
    next = step();
  }
  out.converged = next.is_solved;
  out.proxy = motion_of_tool(tick.tool, next.body);
}

/// Cuts the way at the speed limit: iterations may add up to more.
Pose within_travel(const SoftProxyModel& model, const ToolBody& tool, const Pose& before,
                   const Pose& after) {
  if (!(model.max_travel > 0)) return after;
  const Pose from = motion_of_centre(tool, {before, {}}).X_WC;
  const Pose to = motion_of_centre(tool, {after, {}}).X_WC;
  const LimitedMotion limited = limit_travel(way_between(from, to), tool.radius, model.max_travel);
  return limited.was_cut ? tool_of_centre(tool, moved(from, limited.motion)) : after;
}

/// Start of a massless proxy that cannot reach the hand in this tick.
Pose start_of(const SoftProxyModel& model, const BodyTick& tick, const FreeSpace& space,
              const Pose& X_WP) {
  if (!(model.max_travel > 0)) return X_WP;
  const Pose X_WC = motion_of_centre(tick.tool, {X_WP, {}}).X_WC;
  const Pose X_hand = motion_of_centre(tick.tool, tick.hand).X_WC;
  const std::optional<Pose> nearer = space.nearest_to(X_hand, X_WC);
  return nearer ? tool_of_centre(tick.tool, *nearer) : X_WP;
}

void find_equilibrium(const SoftProxyModel& model, const SoftContacts& contacts,
                      const BodyTick& tick, const Pose& start, BodySolution& out) {
  const QuasiStaticResult next = solve_quasi_static(tick.coupling, tick.tool, tick.hand.X_WT,
                                                    contacts.view(), start, {model.max_travel});
  const Pose before = out.proxy.X_WT;
  out.converged = next.converged;
  out.proxy.X_WT = within_travel(model, tick.tool, start, next.X_WP);
  const Vec3 turn = to_rotation_vector(out.proxy.X_WT.q * conjugate(before.q));
  out.proxy.V_WT = {(out.proxy.X_WT.p - before.p) / tick.dt, turn / tick.dt};
}

}  // namespace

BodySolution solve_soft_proxy(const SoftProxyModel& model, SoftProxyState& state,
                              const BodyTick& tick) {
  HAPTIC_ASSERT(tick.contacts != nullptr && tick.dt > 0 && !(model.max_travel < 0));
  BodySolution out(tick);
  // without mass and velocity, dampers have no effect and the rest of a wrench no counterweight
  const bool is_still = model.solver == SoftSolver::kQuasiStatic;
  SoftContacts contacts =
      carry_soft_contacts(*tick.contacts, tick.tool,
                          {tick, model.contact_stiffness, is_still ? 0 : model.contact_damping});
  if (is_still) contacts.has_rest = contacts.has_brake = false;
  out.finite = contacts.finite;
  if (!state.started || !out.finite) state.proxy = tick.hand;
  state.started = true;
  out.proxy = state.proxy;
  if (!out.finite) return out;
  const FreeSpace space(*tick.contacts, tick.tool, tick);
  const ToolMotion& faded = model.solver == SoftSolver::kDirect ? tick.hand : state.proxy;
  fade_past_extent(motion_of_centre(tick.tool, faded).X_WC, contacts);
  // a proxy with mass need not be where the hand is
  const bool is_massless = model.solver != SoftSolver::kPenaltyDynamics;
  if (is_massless && space.left_at(motion_of_centre(tick.tool, tick.hand).X_WC) > 0) {
    out.proxy = state.proxy = tick.hand;
    return out;
  }
  switch (model.solver) {
    case SoftSolver::kDirect:
      out.proxy = tick.hand;
      out.F_hand_W = direct_wrench(tick, contacts);
      break;
    case SoftSolver::kPenaltyDynamics:
      step_dynamics(model, contacts, tick, space, out);
      out.F_hand_W = wrench_on_hand(tick.coupling, tick.hand, out.proxy);
      break;
    case SoftSolver::kQuasiStatic:
      find_equilibrium(model, contacts, tick, start_of(model, tick, space, out.proxy.X_WT), out);
      out.F_hand_W = wrench_on_hand(tick.coupling, {tick.hand.X_WT, {}}, {out.proxy.X_WT, {}});
      break;
  }
  note_soft_pushes(contacts, tick.tool, motion_of_centre(tick.tool, out.proxy), out);
  state.proxy = out.proxy;
  return out;
}

}  // namespace haptic

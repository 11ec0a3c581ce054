// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/constrained6.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/qp.h"
#include "servo/solve/coupled_body.h"

namespace haptic {
namespace {

Mat6 mass_of(const ToolBody& tool, const Quat& q_WC) {
  return mass_matrix(tool.mass, inertia_of(tool, q_WC));
}

/// The problem of this tick, about C at X_WG.
struct ConstrainedProblem {
  RigidContacts contacts;
  Pose X_WGC;                                // centre of mass at X_WG
  Vec3 arm_W;                                // from the tool's origin to C there
  std::array<MotionRow, kMaxContacts> rows;  // relaxed towards the hand; objects one tick ago
  Twist hand;
  Twist V_carrier_W;
  MotionMetric metric;  // the body's mass and inertia

  std::span<const MotionRow> view() const { return {rows.data(), contacts.size}; }
};

Vec3 object_velocity(const RigidContact& c) {
  return velocity_at(c.V_W, c.r_W);
}

void pose_problem(const BodyTick& tick, ConstrainedProblem& problem) {
  const Pose& X_WG = problem.contacts.X_WG;
  problem.X_WGC = motion_of_centre(tick.tool, {X_WG, {}}).X_WC;
  problem.arm_W = problem.X_WGC.p - X_WG.p;
  const Pose X_WC_hand = motion_of_centre(tick.tool, tick.hand).X_WC;
  problem.hand = way_between(problem.X_WGC, X_WC_hand);
  for (size_t i = 0; i < problem.contacts.size; ++i) {
    const RigidContact& c = problem.contacts.contacts[i];
    problem.rows[i] = eased(row_of(c, problem.arm_W), problem.hand, c.weight);
    // the body has not yet followed what the objects did in this tick
    problem.rows[i].b -= tick.dt * dot(c.normal_W, object_velocity(c));
  }
  problem.V_carrier_W = object_twist(tick, problem.contacts.carrier, problem.X_WGC.p);
  problem.metric = factor_metric(mass_of(tick.tool, X_WG.q));
}

/// Pose of the hand one tick ago, as far as the contacts allow.
BodyMotion first_body(const BodyTick& tick, const ConstrainedProblem& problem) {
  ToolMotion hand = tick.hand;
  hand.X_WT = extrapolate(hand.X_WT, hand.V_WT, -tick.dt);
  BodyMotion body = motion_of_centre(tick.tool, hand);
  const Twist way = way_between(problem.X_WGC, body.X_WC);
  const ConstrainedMotion motion = least_constraint(problem.metric, way, problem.view());
  if (motion.n_active > 0) body.X_WC = moved(problem.X_WGC, motion.a);
  return body;
}

/// Moves the body out of the rows it violates; returns its pose as a motion from X_WG.
Twist project_back(const Constrained6Model& model, const BodyTick& tick,
                   const ConstrainedProblem& problem, BodyMotion& body) {
  const Twist at = way_between(problem.X_WGC, body.X_WC);
  const double share = model.blend_time > tick.dt ? tick.dt / model.blend_time : 1;
  std::array<MotionRow, kMaxContacts> rows;
  for (size_t i = 0; i < problem.contacts.size; ++i) {
    rows[i] = eased(problem.rows[i], at, share);
  }
  const ConstrainedMotion motion =
      least_constraint(problem.metric, at, {rows.data(), problem.contacts.size});
  if (motion.n_active == 0) return at;
  const Quat before = body.X_WC.q;
  body.X_WC = moved(problem.X_WGC, motion.a);
  // keeps the spin in body axes, so the energy is kept
  body.V_WC.w = rotate(body.X_WC.q * conjugate(before), body.V_WC.w);
  return motion.a;
}

/// The metric M + h B + h² K, and the velocity that the coupling alone would give the body.
struct FreeStep {
  MotionMetric metric;
  Twist v;
};
FreeStep free_step(const BodyTick& tick, const Mat6& M, const BodyMotion& body) {
  const BodyWrench spring = symmetric_coupling_wrench(tick.coupling, tick.tool, tick.hand, body);
  const double h = tick.dt;
  HAPTIC_ASSERT(h > 0);
  Mat6 A = M;
  A += -h * spring.by_twist;
  A += -(h * h) * spring.by_motion;
  const MotionMetric metric = factor_metric(A);
  const Wrench F = spring.F_W + h * (spring.by_motion * body.V_WC);
  return {metric, body.V_WC + response(metric, h * F)};
}

/// Contacts of the velocity step, body at `at`, relative to the carrier object. Gaps are those
/// before the objects moved.
void pose_contacts(const ConstrainedProblem& problem, const Twist& at, double h,
                   std::array<FrictionContact, kMaxContacts>& out) {
  for (size_t i = 0; i < problem.contacts.size; ++i) {
    const RigidContact& c = problem.contacts.contacts[i];
    const double gap = std::max(dot(problem.rows[i].J, at) - problem.rows[i].b, 0.0);
    const Vec3 lever_W = c.r_W - problem.arm_W;
    const bool carries = c.object == problem.contacts.carrier;
    const Vec3 velocity_W =
        carries ? Vec3{} : object_velocity(c) - velocity_at(problem.V_carrier_W, lever_W);
    out[i] = {lever_W, c.normal_W, -gap / h, c.friction, velocity_W};
  }
}

/// The complementarity problem of the normals alone, without regard to friction.
FrictionStep frictionless_step(LcpSolver& solver, const FreeStep& free,
                               std::span<const FrictionContact> contacts,
                               std::span<Vec3> impulses) {
  std::array<MotionRow, kMaxContacts> rows;
  for (size_t i = 0; i < contacts.size(); ++i) {
    const FrictionContact& c = contacts[i];
    rows[i] = {{c.normal, cross(c.r, c.normal)},
               c.least_speed + dot(c.normal, c.obstacle_velocity)};
  }
  const ImpulseStep step =
      solver.step(LcpMethod::kPivoting, free.metric, free.v, {rows.data(), contacts.size()});
  FrictionStep out;
  out.v = step.v;
  out.converged = step.converged;
  out.impulses = impulses.first(contacts.size());
  if (!step.converged) return out;
  for (size_t i = 0; i < contacts.size(); ++i) impulses[i] = step.lambda[i] * contacts[i].normal;
  return out;
}

/// The body's velocity after the step; `impulses` is memory for those of the contacts.
FrictionStep velocity_step(RigidSolver solver, ContactSolvers& solvers, const FreeStep& free,
                           std::span<const FrictionContact> contacts, std::span<Vec3> impulses) {
  if (solver == RigidSolver::kLcp) {
    const FrictionStep step = frictionless_step(solvers.lcp, free, contacts, impulses);
    if (step.converged) return step;
  }
  return solvers.coulomb.step(free.metric, free.v, contacts, kMaxFrictionSolves);
}

/// Notes the pushes on the objects and which contacts slide.
void note_pushes(const ConstrainedProblem& problem, const FrictionStep& step, double h,
                 const Pose& X_WC, Slides& slides, BodySolution& out) {
  slides = {};
  const Vec3 arm_W = X_WC.p - out.proxy.X_WT.p;
  for (size_t i = 0; i < step.impulses.size(); ++i) {
    const Vec3 push_W = step.impulses[i] / h;
    if (push_W == Vec3{}) continue;
    const RigidContact& c = problem.contacts.contacts[i];
    const Vec3 lever_W = c.r_W - problem.arm_W;
    ++out.n_pushing;
    Wrench& sum = out.push_W[c.object];
    sum = sum + shift({push_W, cross(lever_W, push_W)}, arm_W);
    const Vec3 slip_W = velocity_at(step.v + problem.V_carrier_W, lever_W) - object_velocity(c);
    slides[c.object] |= is_sliding(c, slip_W);
  }
}

}  // namespace

BodySolution solve_constrained6(const Constrained6Model& model, const Materials& materials,
                                Constrained6State& state, ContactSolvers& solvers,
                                const BodyTick& tick) {
  HAPTIC_ASSERT(tick.dt > 0 && model.blend_time >= 0);
  BodySolution out(tick);
  ConstrainedProblem problem;
  problem.contacts = carry_rigid_contacts(materials, tick, state.slides);
  out.finite = problem.contacts.finite;
  if (!out.finite) {
    state = {};
    return out;
  }
  pose_problem(tick, problem);
  BodyMotion& body = state.body;
  if (!state.started) body = first_body(tick, problem);
  state.started = true;
  const Pose X_WP = tool_of_centre(tick.tool, body.X_WC);
  const SurfacePlaces places{{&X_WP, 1}, {&X_WP, 1}};
  if (follow_surfaces(tick, places, problem.contacts)) pose_problem(tick, problem);

  const Twist at = project_back(model, tick, problem, body);
  const FreeStep free = free_step(tick, mass_of(tick.tool, body.X_WC.q), body);
  std::array<FrictionContact, kMaxContacts> contacts;
  pose_contacts(problem, at, tick.dt, contacts);
  std::array<Vec3, kMaxContacts> impulses;
  const FrictionStep step =
      velocity_step(model.solver, solvers, {free.metric, free.v - problem.V_carrier_W},
                    {contacts.data(), problem.contacts.size}, impulses);
  body.V_WC = step.v + problem.V_carrier_W;
  body.X_WC = moved(body.X_WC, tick.dt * body.V_WC);

  out.converged = step.converged && !step.contradictory;
  out.proxy = motion_of_tool(tick.tool, body);
  out.F_hand_W = wrench_on_hand(tick.coupling, tick.hand, out.proxy);
  note_pushes(problem, step, tick.dt, body.X_WC, state.slides, out);
  return out;
}

}  // namespace haptic

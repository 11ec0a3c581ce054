// SPDX-License-Identifier: GPL-3.0-or-later
// Rows that hold both ways, for every renderer: the tool that a solver sees is drawn to where they
// hold it.
#include "servo/render/grasped.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "proto/math/assert.h"
#include "proto/wire/renderer.h"
#include "servo/render/body_solver.h"
#include "servo/solve/coupled_body.h"
#include "servo/solve/guide_rows.h"

namespace haptic {
namespace {

constexpr double kPointRadius = 0.01;  // stands for that of a tool that is a point [m]

/// How a body that has been left behind comes after: as a slow hand moves, and so gently that a
/// hand at rest feels no more of its start and stop than m · rise, 50 mN of 100 g.
struct TakeUp {
  double speed, rise;
};
constexpr TakeUp kTakeUp{0.05, 0.5};        // [m/s], [m/s²]
constexpr TakeUp kTakeUpTurning{0.5, 5.0};  // [rad/s], [rad/s²]
// by which more than before it may pull to catch what has fallen: at a fifth of gravity that takes
// 0.1 s and 5 mm after a standstill of 50 ms; 0.2 N is what a resting hand may feel of it
constexpr double kCatch = 0.2;
constexpr double kLeastCatch = 0.2;         // [N]
constexpr double kLeastCatchTorque = 2e-3;  // the same 10 mm off [N·m]
constexpr double kMostCatching = 1;         // a hand that goes on is followed then [s]
// slower, body and hand are taken to move as one: less than a millimetre in that time
constexpr double kApart = 1e-3;         // [m/s]
constexpr double kApartTurning = 0.01;  // [rad/s]

bool is_body(const RenderQuestion& question) {
  return is_of_body(static_cast<Renderer>(question.contacts.renderer));
}

MotionMetric metric_of(const ServoModel& model, const RenderQuestion& question) {
  const double radius =
      is_body(question) ? tool_in_force(model, question.contacts).radius : kPointRadius;
  return spring_metric(with_least_springs(question.coupling, radius));
}

/// The rows of a first set hold the tool where contact has it.
GraspState begun(uint32_t object, const RenderQuestion& question) {
  GraspState state;
  state.object = object;
  state.X_WT = question.X_WT;
  if (object < question.contacts.objects.size()) {
    state.X_OP = inverse(question.contacts.objects[object].X_WO) * place_of(question.contacts);
  }
  return state;
}

Vec3 bounded(const Vec3& v, double most) {
  const double length = norm(v);
  return most > 0 && length > most ? most / length * v : v;
}

/// In scene units, no more than a bound of the coupling; 0: none.
double bound_of(double limit, double force_scale, double of_coupling) {
  HAPTIC_ASSERT(force_scale > 0);
  const double most = limit / force_scale;
  return of_coupling > 0 && (of_coupling < most || !(most > 0)) ? of_coupling : most;
}

/// The vector, shorter by `by` ≥ 0 but no shorter than zero.
Vec3 shortened(const Vec3& v, double by) {
  HAPTIC_ASSERT(by >= 0);
  const double length = norm(v);
  return length > by ? (1 - by / length) * v : Vec3{};
}

/// The slip a tick later; its speed rises and falls by as much as that, to end at rest.
Vec3 taken_up(const Vec3& slip, const TakeUp& how, double dt, double& speed) {
  speed = std::min({speed + how.rise * dt, how.speed, std::sqrt(2 * how.rise * norm(slip))});
  return shortened(slip, speed * dt);
}

/// How hard the hold may pull while it gives way.
struct Pull {
  double force, torque;
};

/// It gives way while sim or contact stand still, no harder than before, and afterwards until body
/// and hand move apart no more, for a second at most: what has fallen is caught with little more.
/// None: it pulls as its springs do.
std::optional<Pull> bound_on(const Twist& whole, const Twist& V, bool is_stale, double dt,
                             GraspState& state) {
  const auto recedes = [](const Vec3& way, const Vec3& v, double least) {
    return dot(way, v) > least * norm(way);
  };
  const bool apart = recedes(whole.v, V.v, kApart) || recedes(whole.w, V.w, kApartTurning);
  const double left = apart ? std::max(state.gives_way - dt, 0.0) : 0;
  state.gives_way = is_stale ? kMostCatching : left;
  if (state.gives_way == 0) return std::nullopt;
  if (is_stale) return Pull{state.force, state.torque};
  return Pull{state.force + std::max(kCatch * state.force, kLeastCatch),
              state.torque + std::max(kCatch * state.torque, kLeastCatchTorque)};
}

/// The spring's way, without the slip: by which it gives way, and which is taken up again.
Twist spring_way(const ServoModel& model, const Twist& whole, const Coupling& c,
                 const std::optional<Pull>& most, GraspState& state) {
  if (!most) {
    state.slip = {taken_up(state.slip.v, kTakeUp, model.dt, state.speed),
                  taken_up(state.slip.w, kTakeUpTurning, model.dt, state.spin)};
    return whole - state.slip;
  }
  state.speed = state.spin = 0;
  Twist way = whole - state.slip;
  const auto give_way = [&](Vec3& part, double stiffness, double bound) {
    const double pull = norm(part) * state.strength * stiffness;
    if (pull > bound) part = bound / pull * part;
  };
  give_way(way.v, c.translational_stiffness, most->force);
  give_way(way.w, c.rotational_stiffness, most->torque);
  state.slip = whole - way;
  return way;
}

Wrench wrench_of(const ServoModel& model, const Hold& hold, const RenderQuestion& question,
                 bool is_stale, GraspState& state) {
  const Coupling& c = question.coupling;
  const Twist whole = way_between(question.X_WT, hold.X_WP), V = hold.V_WP - question.V_WT;
  const std::optional<Pull> most = bound_on(whole, V, is_stale, model.dt, state);
  const Twist way = spring_way(model, whole, c, most, state);
  const double scale = model.map.force_scale;
  Wrench F;
  F.f = bounded(hold.share * (c.translational_stiffness * way.v + c.translational_damping * V.v),
                bound_of(model.limits.max_force, scale, c.max_force));
  if (is_body(question)) {
    F.t = bounded(hold.share * (c.rotational_stiffness * way.w + c.rotational_damping * V.w),
                  bound_of(model.limits.max_torque, scale, c.max_torque));
  }
  if (most) {
    return {shortened(F.f, std::max(norm(F.f) - most->force, 0.0)),
            shortened(F.t, std::max(norm(F.t) - most->torque, 0.0))};
  }
  state.force = norm(F.f);
  state.torque = norm(F.t);
  return F;
}

}  // namespace

Hold hold_of(const ServoModel& model, GraspState& state, const RenderQuestion& question,
             const HeldBody& body) {
  HAPTIC_ASSERT(model.dt > 0 && state.strength >= 0);
  Hold hold;
  const GuideRows guides = body.is_wanted ? guide_rows(question.contacts) : GuideRows{};
  if (guides.object != state.object) state = begun(guides.object, question);
  if (guides.object >= question.scene.X_WO.size()) return hold;
  state.strength = std::min(state.strength + model.dt / kGraspTime, 1.0);

  const TickScene& scene = question.scene;
  const Pose& X_WO = scene.X_WO[guides.object];
  if (!is_finite(X_WO) || !is_finite(question.X_WT) || !is_finite(state.X_OP)) return hold;
  hold.object = guides.object;
  hold.n_rows = static_cast<int>(guides.rows.size());
  hold.share = state.strength * scene.weight;
  hold.X_WP =
      nearest_on_guides(guides, X_WO, question.X_WT, X_WO * state.X_OP, metric_of(model, question));
  state.X_OP = inverse(X_WO) * hold.X_WP;
  hold.V_WP = twist_with(scene.V_WO[guides.object], hold.X_WP.p - X_WO.p);
  // a point has no orientation of its own
  if (!is_body(question)) hold.V_WP.w = question.V_WT.w;
  hold.F_W = wrench_of(model, hold, question, body.stands || scene.weight < 1, state);
  return hold;
}

void draw_tool(const Hold& hold, GraspState& state, RenderQuestion& question, TickScene& scene) {
  if (!hold.holds()) return;
  HAPTIC_ASSERT(hold.share >= 0 && hold.share <= 1);
  question.X_WT = drawn_towards(question.X_WT, hold.X_WP, hold.share);
  question.V_WT = drawn_towards(question.V_WT, hold.V_WP, hold.share);
  question.X_WT_before = state.X_WT;
  state.X_WT = question.X_WT;
  scene.held = hold.object;
  scene.held_share = 1 - state.strength;
}

void add_hold(const Hold& hold, const RenderQuestion& question, Rendered& rendered) {
  if (!hold.holds() || !(hold.share > 0) || !rendered.finite) return;
  rendered.F_W = rendered.F_W + hold.F_W;
  rendered.n_pushing += hold.n_rows;
  rendered.surface_W = hold.V_WP.v;
  rendered.surface_turning_W = is_body(question) ? hold.V_WP.w : Vec3{};
  Wrench& push_W = rendered.push_W[hold.object];
  push_W = push_W + shift(hold.F_W, hold.X_WP.p - rendered.X_WP.p);
}

}  // namespace haptic

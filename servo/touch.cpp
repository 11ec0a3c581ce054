// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/touch.h"

#include <algorithm>
#include <type_traits>

#include "proto/math/assert.h"
#include "proto/wire/mapping.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr size_t kMostOfSolver = 16 * 1024;  // [bytes]: the state of a servo stays in its cache

/// The objects in this tick: the newest scene carried on by twist and pushes, else where contact
/// saw them.
TickScene scene_of(const ServoModel& model, ServoState& state, const ServoInput& input,
                   double weight) {
  TickScene scene;
  scene.weight = weight;
  const PushCounters& pushes = state.pushes;
  const HandPush push{model.hand, pushes.t_ns, pushes.since_ns, pushes.objects};
  const uint32_t n_moved =
      input.scene != nullptr ? static_cast<uint32_t>(input.scene->objects.size()) : 0;
  for (uint32_t i = 0; i < n_moved; ++i) {
    const UnseenPush unseen = unseen_push(*input.scene, i, input.t_ns, push);
    scene.X_WO.push_back(object_pose_at(*input.scene, i, input.t_ns, unseen));
    scene.V_WO.push_back(object_twist_at(*input.scene, i, input.t_ns, unseen));
  }
  if (input.contacts == nullptr) return scene;
  for (size_t i = n_moved; i < input.contacts->objects.size(); ++i) {
    scene.X_WO.push_back(input.contacts->objects[i].X_WO);
    scene.V_WO.push_back({});
  }
  scene.place_surfaces(*input.contacts, state.surfaces);
  for (PlacedSurface& s : scene.surfaces) s.share = share_of(model, state.clients, s.client);
  return scene;
}

/// Looks at the button of a grasp and at the object that is held.
HeldBody held_body(const ServoModel& model, const ServoState& state, const ServoInput& input) {
  HeldBody body;
  body.is_wanted =
      is_pressed(input.device, model.map.grasp_button) && !state.clutch.held && !model.admittance;
  const uint32_t object = state.grasp.object;
  if (input.scene == nullptr || object >= input.scene->objects.size()) return body;
  const PushCounters& pushes = state.pushes;
  body.stands = is_mobile(*input.scene, object) &&
                !takes_pushes(*input.scene, object, model.hand, pushes.since_ns, pushes.t_ns);
  return body;
}

template <class Solver>
Rendered rendered_with(const ServoModel& model, const RenderQuestion& question,
                       RenderState& state) {
  // begun and dropped within a tick: it must neither allocate nor throw
  static_assert(std::is_nothrow_default_constructible_v<Solver> &&
                std::is_trivially_copyable_v<Solver> && sizeof(Solver) <= kMostOfSolver);
  auto* solver = std::get_if<Solver>(&state.solver);
  if (solver == nullptr) solver = &state.solver.emplace<Solver>();
  return solver->render(model, question, state.contact_solvers);
}

/// Asks the solver of a renderer. Another one than in the last tick begins anew.
Rendered rendered_by(Renderer renderer, const ServoModel& model, const RenderQuestion& question,
                     RenderState& state) {
  switch (renderer) {
#define RENDERER(id, name, detector, solver, ...) \
  case Renderer::id:                              \
    return rendered_with<solver>(model, question, state);
#include "proto/wire/renderers.def"
  }
  HAPTIC_ASSERT(false);
  return {};
}

/// Two tools that meet are two springs in series: of its own spring's force a hand feels the share
/// k_other / (k + k_other). It changes no faster than within kYield, where a hand begins to feel
/// nothing or to feel again.
void share_with_tools(const ServoModel& model, ServoState& state, const ServoInput& input,
                      const Coupling& coupling, KeptShares& shares) {
  constexpr double kYield = 0.050;  // [s], as contacts fade
  const size_t n = input.tool_stiffness.size();
  if (input.scene == nullptr || n > input.scene->objects.size()) return;
  const size_t first = input.scene->objects.size() - n;
  for (size_t k = 0; k < n; ++k) {
    const double sum = coupling.translational_stiffness + input.tool_stiffness[k];
    const double wanted = sum > 0 ? input.tool_stiffness[k] / sum : 0;
    double& share = state.tool_shares[k];
    share = std::clamp(wanted, share - model.dt / kYield, share + model.dt / kYield);
    if (first + k < shares.size()) shares[first + k] *= share;
  }
}

/// The answer of the contacts' renderer. What the hand holds draws the tool that is rendered, and
/// pulls beside.
Rendered solve_proxy(const ServoModel& model, ServoState& state, const ServoInput& input,
                     const Tool& tool, const Coupling& coupling, Touch& touch) {
  // nothing is known of what a detector without a name has found
  const RendererRow* renderer = renderer_of(input.contacts);
  if (renderer == nullptr) {
    Rendered none(touch.scene);
    none.X_WP = tool.X_WT;
    return none;
  }
  RenderQuestion question{*input.contacts, touch.scene,  coupling,   tool.X_WT,
                          tool.V_WT,       std::nullopt, input.t_ns, state.soft_solver};
  if (state.started) question.X_WT_before = state.X_WT;
  const RenderQuestion of_hand = question;
  const Hold hold = hold_of(model, state.grasp, question, held_body(model, state, input));
  draw_tool(hold, state.grasp, question, touch.scene);
  Rendered rendered = rendered_by(renderer->id, model, question, state.render);
  add_hold(hold, question, rendered);
  // the body of an admittance device stops where the scene does: all that it loses is the object's
  if (model.admittance) return rendered;
  KeptShares shares(rendered.push_W.size(), 1.0);
  if (soften_towards_light(model, question, input.scene, rendered, state.light, shares)) {
    touch.flags |= kServoSoftened;
  }
  share_with_tools(model, state, input, coupling, shares);
  keep_surfaces(model, of_hand, rendered, shares);
  touch.clients = felt_of_clients(model, state.clients, of_hand, shares, rendered);
  keep(shares, touch.scene, rendered);
  return rendered;
}

/// The proxy's velocity where its solver does not know it: its way since the last tick.
Twist velocity_since(const ServoState& state, const Pose& X_WP, int64_t t_ns) {
  const double since = static_cast<double>(t_ns - state.t_ns) * 1e-9;
  if (!state.started || since <= 0) return {};
  return {(X_WP.p - state.X_WP.p) / since, {}};
}

}  // namespace

Touch touch_of(const ServoModel& model, ServoState& state, const ServoInput& input,
               const Tool& tool, const Coupling& coupling, double weight) {
  Touch touch;
  touch.scene = scene_of(model, state, input, weight);
  touch.coupling = coupling;
  touch.rendered = solve_proxy(model, state, input, tool, coupling, touch);
  Rendered& rendered = touch.rendered;
  rendered.finite &= touch.clients.finite;
  if (!rendered.converged) touch.flags |= kServoSolverLimit;
  if (rendered.n_pushing > 0) touch.flags |= kServoContact;
  touch.V_WP = rendered.V_WP ? *rendered.V_WP : velocity_since(state, rendered.X_WP, input.t_ns);
  touch.depth = norm(rendered.X_WP.p - tool.X_WT.p);
  return touch;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/render/body_solver.cpp: ticks of a 6-DoF tool on hand-made contacts.
#include <limits>
#include <memory>

#include "proto/wire/renderer.h"
#include "servo/step.h"
#include "tests/support/near.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A set of the renderer voxel: one soft contact on the tool's point p_T.
std::unique_ptr<ContactSet> soft_set(const Vec3& tool_point_T, double stiffness) {
  auto set = set_of({plane({0, 0, 1}, {})});
  set->renderer = static_cast<uint32_t>(haptic::Renderer::kVoxel);
  set->contacts[0].tool_point_T = tool_point_T;
  set->contacts[0].object_point_O = {tool_point_T.x, tool_point_T.y, 0};
  set->contacts[0].stiffness = stiffness;
  set->tool = {0.1, {1e-4, 1e-4, 1e-4}, {}, 0.02};
  return set;
}

/// Held in place until its proxy rests.
ServoFrame settled(const ServoModel& model, const ContactSet& set, const Vec3& p_W) {
  ServoState state;
  const SceneFrame scene = still_scene(static_cast<uint32_t>(set.objects.size()));
  ServoFrame f{};
  for (int64_t k = 1; k <= 2000; ++k) {
    ContactSet now = set;
    now.seq = static_cast<uint64_t>(k);
    now.answers_t_ns = (k - 1) * kMs;
    ServoInput input = input_at(k, p_W, &now);
    input.scene = &scene;
    f = step_armed(model, state, input);
  }
  return f;
}

}  // namespace

TEST_CASE("servo: a tool with six degrees of freedom feels coupling and contact in series",
          "[servo]") {
  // k_vc k_c/(k_vc + k_c) times the depth; direct: k_c alone
  const double k_vc = 800, k_c = 3000, depth = 1e-3;
  const auto set = soft_set({}, k_c);
  ServoModel model = plain_model(k_vc);
  using haptic::SoftSolver;
  const SoftSolver solver =
      GENERATE(SoftSolver::kDirect, SoftSolver::kPenaltyDynamics, SoftSolver::kQuasiStatic);
  model.proxy.solver = solver;
  model.coupling.translational_damping = 2;
  const ServoFrame f = settled(model, *set, {0, 0, -depth});
  const double k = solver == SoftSolver::kDirect ? k_c : k_vc * k_c / (k_vc + k_c);
  CHECK_THAT(f.F_device_B.f, IsNear({0, 0, k * depth}, 1e-6));
  CHECK((f.flags & haptic::kServoContact) != 0);
  CHECK(f.n_contacts == 1);
  // the proxy is above the hand; direct has none
  const double above = solver == SoftSolver::kDirect ? 0 : k * depth / k_vc;
  CHECK_THAT(f.X_WP.p, IsNear({0, 0, -depth + above}, 1e-9));
  // the object was pushed the opposite way, over two seconds
  if (solver != SoftSolver::kPenaltyDynamics) {
    CHECK(f.pushes[0].impulse_W.f.z == Approx(-2 * k * depth).epsilon(2e-3));
  }
}

TEST_CASE("servo: a contact beside the tool's origin turns it, about the grip", "[servo]") {
  const double k_c = 3000, depth = 1e-3, arm = 0.01;
  const auto set = soft_set({arm, 0, 0}, k_c);
  ServoModel model = plain_model(800);
  model.proxy.solver = haptic::SoftSolver::kDirect;
  const ServoFrame f = settled(model, *set, {0, 0, -depth});
  CHECK_THAT(f.F_coupling_W.t, IsNear({0, -arm * k_c * depth, 0}, 1e-12));
  // the handle is 5 cm beside the tool, which gives the force a lever arm
  model.map.X_HT.p = {0.05, 0, 0};
  const ServoFrame held = settled(model, *set, {-0.05, 0, -depth});
  CHECK_THAT(held.F_device_B.t, IsNear({0, -(0.05 + arm) * k_c * depth, 0}, 1e-12));
}

TEST_CASE("servo: contacts of a tool that are not finite are a fault", "[servo]") {
  auto set = soft_set({}, std::numeric_limits<double>::quiet_NaN());
  ServoState state;
  const ServoFrame f = step_armed(plain_model(800), state, input_at(1, {0, 0, -1e-3}, set.get()));
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK(f.fault == static_cast<uint32_t>(haptic::Fault::kContactsNotFinite));
}

TEST_CASE("servo: a point that takes over from a body begins anew", "[servo][trap]") {
  // many contacts of a body must not be treated as features of a point
  auto soft = soft_set({}, 3000);
  for (int i = 1; i < 8; ++i) soft->contacts.push_back(soft->contacts[0]);
  ServoModel model = plain_model(800);
  model.limits.slew = 1;
  ServoState state;
  step_armed(model, state, input_at(1, {0, 0, -1e-3}, soft.get()));
  const auto hard = set_of({plane({0, 0, 1}, {})});
  const ServoFrame f = step_armed(model, state, input_at(2, {0, 0, -1e-3}, hard.get()));
  // the hand has not moved: a new contact fades in
  CHECK((f.flags & haptic::kServoSlewing) != 0);
}

TEST_CASE("servo: what was felt before direct6 does not limit the force after it",
          "[servo][trap]") {
  const auto set = soft_set({}, 3000);
  const ServoModel model = plain_model(800);
  ServoState state;
  for (int64_t k = 1; k <= 20; ++k) {
    ContactSet now = *set;
    now.seq = static_cast<uint64_t>(k);
    now.answers_t_ns = (k - 1) * kMs;
    // both are rendered by the same function
    if (k == 20) now.renderer = static_cast<uint32_t>(haptic::Renderer::kDirect6);
    step_armed(model, state, input_at(k, {0, 0, -1e-3}, &now));
    CHECK(std::get<haptic::SoftProxySolver>(state.render.solver).felt.started == (k < 20));
  }
}

TEST_CASE("servo: while nothing is felt a body's proxy is at the hand", "[servo]") {
  const auto set = soft_set({}, 3000);
  ServoModel model = plain_model(800);
  ServoState state;
  haptic::ControlFrame control{};
  control.armed = 1;
  control.translational_stiffness = 800;
  for (int64_t k = 1; k <= 20; ++k) {
    ServoInput input = input_at(k, {0, 0, -1e-3}, set.get());
    input.control = &control;
    const ServoFrame f = step_armed(model, state, input);
    CHECK(is_started<haptic::SoftProxySolver>(state));
    CHECK(f.X_WP.p.z > -1e-3);
  }
  control.paused = 1;
  ServoInput paused = input_at(21, {0, 0, -2e-3}, set.get());
  paused.control = &control;
  CHECK(step_armed(model, state, paused).F_device_B == haptic::Wrench{});
  CHECK_FALSE(is_started<haptic::SoftProxySolver>(state));
}

TEST_CASE("servo: what the objects are pushed with is what the hand feels", "[servo]") {
  using haptic::SoftSolver;
  const SoftSolver solver =
      GENERATE(SoftSolver::kDirect, SoftSolver::kPenaltyDynamics, SoftSolver::kQuasiStatic);
  // a linearised wrench beyond the springs, which quasi-static does not use
  auto set = soft_set({0.005, 0, 0}, 2000);
  set->trust_radius = 1e-3;
  set->X_WT.p = {0, 0, -1e-3};
  set->F0_W = {{0, 0, 3}, {0, -0.01, 0}};
  ServoModel model = plain_model(800);
  model.proxy.solver = solver;
  model.coupling = {800, 2, 2, 2e-3};
  ServoState state;
  haptic::Wrench before{};
  ServoFrame f{};
  const SceneFrame scene = still_scene(1);
  for (int64_t k = 1; k <= 3000; ++k) {
    before = state.pushes.objects[0].impulse_W;
    set->seq = static_cast<uint64_t>(k);
    set->answers_t_ns = (k - 1) * kMs;
    ServoInput input = input_at(k, {0, 0, -1e-3}, set.get());
    input.scene = &scene;
    f = step_armed(model, state, input);
  }
  CHECK(norm(f.F_coupling_W.f) > 0.1);
  const haptic::Wrench pushed = state.pushes.objects[0].impulse_W;
  // dynamics bounds the rest of the wrench by the springs at the end of a step without it
  const double error =
      solver == SoftSolver::kPenaltyDynamics ? 0.02 * norm(f.F_coupling_W.f) : 1e-6;
  CHECK_THAT((pushed.f - before.f) / 1e-3, IsNear(-f.F_coupling_W.f, error));
}

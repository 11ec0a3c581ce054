// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/step.cpp and servo/solve/point/point_proxy.cpp on hand-made contacts.
#include "servo/step.h"
#include "proto/math/units.h"
#include "servo/pushes.h"

#include <limits>
#include <memory>
#include <vector>

#include "proto/wire/renderer.h"
#include "servo/solve/point/point_proxy.h"
#include "tests/support/near.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// For a point without friction, objects at the origin.
PointProxySolution point_proxy(const ContactSet& set, const Vec3& tool_W) {
  haptic::PlanesInForce planes;
  haptic::TickScene at_origin;
  at_origin.X_WO.resize(set.objects.size());
  at_origin.V_WO.resize(set.objects.size());
  return haptic::solve_point_proxy({set, at_origin, tool_W, 0, {}}, planes);
}

}  // namespace

TEST_CASE("servo: plane force is plus k d n, exact (the slide has minus: its normal points in)",
          "[servo][trap]") {
  // the force must push the tool out, whatever the plane's direction
  const double k = 900, depth = 1.7e-3;
  const Vec3 place{0.01, 0.02, 0.003};
  for (const Vec3& n : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, -1, 0}, normalized(Vec3{1, 2, -3})}) {
    const auto set = set_of({plane(n, place)});
    ServoState state;
    const ServoFrame f =
        step_armed(plain_model(k), state, input_at(1, place - depth * n, set.get()));
    CHECK_THAT(f.F_device_B.f, IsNear(k * depth * n, 1e-9));
    CHECK((f.flags & kServoContact) != 0);
    if (n.z == 1) CHECK(f.F_device_B.f.x == 0);
    if (n.z == 1) CHECK(f.F_device_B.f.y == 0);
    // above the plane there is none
    ServoState above;
    const ServoFrame g =
        step_armed(plain_model(k), above, input_at(1, place + 1e-9 * n, set.get()));
    CHECK(g.F_device_B == Wrench{});
    CHECK((g.flags & kServoContact) == 0);
  }
}

TEST_CASE("servo: 90 degree concave corner", "[servo][trap]") {
  const auto set = set_of({plane({1, 0, 0}, {0, 0, 3e-3}), plane({0, 1, 0}, {0, 0, 3e-3})});
  ServoState state;
  const ServoFrame f =
      step_armed(plain_model(1000), state, input_at(1, {-1e-3, -2e-3, 3e-3}, set.get()));
  CHECK_THAT(f.X_WP.p, IsNear({0, 0, 3e-3}, 1e-15));
  CHECK_THAT(f.F_device_B.f, IsNear({1, 2, 0}, 1e-12));
}

TEST_CASE("servo: a corner of small facets holds although the tool is deep in both walls",
          "[servo]") {
  // extents far below the depth: the proxy is in the corner, so both planes push in full
  const auto set = set_of({plane({1, 0, 0}, {0, 0, 0}, 5e-4), plane({0, 1, 0}, {0, 0, 0}, 5e-4)});
  const PointProxySolution s = point_proxy(*set, {-3e-3, -5e-3, 0});
  CHECK_THAT(s.proxy_W, IsNear({0, 0, 0}, 1e-15));
}

TEST_CASE("servo: over-constraint trap", "[servo][trap]") {
  const auto set = set_of({plane({0, 1, 0}, {}, 1), plane({0.6, 0.8, 0}, {}, 1)});
  const PointProxySolution s = point_proxy(*set, {0.1, -1, 0});
  CHECK_THAT(s.proxy_W, IsNear({0.1, 0, 0}, 1e-12));
  CHECK(s.n_active == 1);
}

TEST_CASE("servo: ghost wall trap: beyond its extent a plane gives no force", "[servo][trap]") {
  const auto set = set_of({plane({0, 0, 1}, {}, 1e-3)});
  const double depth = 0.5e-3;
  auto force_at = [&](double x) {
    return 1000 * norm(point_proxy(*set, {x, 0, -depth}).proxy_W - Vec3{x, 0, -depth});
  };
  CHECK(force_at(0.9e-3) == Approx(0.5));
  CHECK(force_at(1.2e-3) == 0);
  // in between it fades without a step: 1 µm of motion changes it by at most 1 % of the full force
  for (int k = 0; k < 300; ++k) {
    const double x = 0.9e-3 + 1e-6 * k;
    CHECK(std::fabs(force_at(x + 1e-6) - force_at(x)) <= 0.5 * 0.0101);
  }
}

TEST_CASE("servo: contacts of a renderer that does not exist are not rendered", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {0, 0, 0.003})});
  set->renderer = GENERATE(static_cast<uint32_t>(kRenderers.size()), 1000u, ~0u);
  ServoState state;
  const ServoFrame f = step_armed(plain_model(900), state, input_at(1, {}, set.get()));
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK(f.X_WP == f.X_WT);
  CHECK(f.n_contacts == 0);
}

TEST_CASE("servo: contacts move with their object", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  SceneFrame scene = still_scene(1);
  set_time(scene, 100 * kMs);
  scene.objects[0].X_WO.p = {0, 0, 0.01};
  scene.objects[0].V_WO.v = {0, 0, 1};
  ServoState state;
  // 5 ms after the scene frame the surface is 5 mm higher
  ServoInput input = input_at(105, {0, 0, 0.014}, set.get());
  input.scene = &scene;
  set->answers_t_ns = 104 * kMs;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  CHECK(f.F_device_B.f.z == Approx(1.0));
  CHECK(f.pushes[0].impulse_W.f.z == Approx(-1.0 * 1e-3));
}

TEST_CASE("servo: a dead sim freezes the scene after 20 ms", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  SceneFrame scene{};
  scene.objects.push_back(scene_object({}, {{0, 0, 0.1}, {}}));
  set_time(scene, 100 * kMs);
  ServoState state;
  ServoInput input = input_at(1100, {0, 0, 0}, set.get());
  input.scene = &scene;
  set->answers_t_ns = 1099 * kMs;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  CHECK(f.depth == Approx(0.1 * 0.020));

  // a surface at rest does not act through the damper either
  ServoModel damped = plain_model(1000);
  damped.coupling.translational_damping = 5;
  ServoState fresh;
  CHECK(step_armed(damped, fresh, input).F_device_B.f.z == Approx(1000 * 0.1 * 0.020));
}

TEST_CASE("servo: the damper fades with the contacts and never steps", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  ServoModel model = plain_model(800);
  model.coupling.translational_damping = 5;
  ServoState state;
  std::vector<double> force;
  // contacts answer until 100 ms, stop for 200 ms and return
  for (int64_t k = 1; k <= 500; ++k) {
    if (k <= 100 || k > 300) {
      set->answers_t_ns = (k - 1) * kMs;
      set->seq = static_cast<uint64_t>(k);
    }
    ServoInput input = input_at(k, {0, 0, -1e-3}, set.get());
    input.device.V_BH.v = {0, 0, -0.2};
    force.push_back(step_armed(model, state, input).F_device_B.f.z);
  }
  const double full = 800 * 1e-3 + 5 * 0.2;
  CHECK(force[80] == Approx(full));
  CHECK(force[250] == 0);
  CHECK(force.back() == Approx(full));
  for (size_t k = 61; k < force.size(); ++k) {
    CHECK(std::fabs(force[k] - force[k - 1]) <= full / 50 * 1.0001);
  }
}

TEST_CASE(
    "servo: a pose that overflows or a scene that is not finite is a fault, not a missing wall",
    "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  const ServoModel model = plain_model(1000);
  ServoInput input = input_at(2, {0, 0, -1e-3}, set.get());
  SceneFrame scene{};
  scene.objects.push_back(scene_object());
  set_time(scene, 2 * kMs);
  SECTION("object position") {
    scene.objects[0].X_WO.p.z = std::numeric_limits<double>::quiet_NaN();
    input.scene = &scene;
  }
  SECTION("object velocity") {
    scene.objects[0].V_WO.v.z = std::numeric_limits<double>::infinity();
    input.scene = &scene;
    input.t_ns += kMs;
  }
  SECTION("device orientation") {
    input.device.X_BH.q.x = 1e200;
  }
  SECTION("device position") {
    input.device.X_BH.p.z = -1.7e308;
  }
  ServoModel far = model;
  far.map.motion_scale = 10;
  ServoState state;
  const ServoFrame f = step_armed(far, state, input);
  CHECK((f.flags & haptic::kServoFault) != 0);
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK(is_finite(f.X_WT));
}

TEST_CASE("servo: a proxy placed anew starts softly even if its set was never seen", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  ServoModel model = plain_model(1000);
  model.limits.soft_start = 0.1;
  ServoState state;
  state.safety.gain = 1;
  ServoInput input = input_at(1, {0, 0, -4e-3}, set.get());
  input.contact_generation = 1;
  CHECK(step_armed(model, state, input).F_device_B.f.z == Approx(4));

  // the set with kContactReseeded was overwritten: only its count is left
  set->reseeds = 1;
  set->seq = 2;
  input.tick = 2, input.t_ns = 2 * kMs;
  CHECK(step_armed(model, state, input).F_device_B.f.z == 0);
  // one soft start per re-placement, and none for a restarted contact that took over the proxy
  input.tick = 3, input.t_ns = 3 * kMs;
  CHECK(step_armed(model, state, input).F_device_B.f.z > 0);
  set->reseeds = 0;
  input.contact_generation = 2;
  input.tick = 4, input.t_ns = 4 * kMs;
  CHECK(step_armed(model, state, input).F_device_B.f.z > 0);
  set->reseeds = 1;
  input.contact_generation = 3;
  input.tick = 5, input.t_ns = 5 * kMs;
  CHECK(step_armed(model, state, input).F_device_B.f.z == 0);
}

TEST_CASE("servo: nothing is pushed while nothing is felt", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  const ServoModel model = plain_model(1000);
  ServoState state;
  haptic::ControlFrame control{};
  control.translational_stiffness = 1000;
  control.armed = 1;
  ServoInput input = input_at(1, {0, 0, -1e-3}, set.get());
  const SceneFrame scene = still_scene(1);
  input.scene = &scene;
  input.control = &control;
  const double before = step_armed(model, state, input).pushes[0].impulse_W.f.z;
  CHECK(before == Approx(-1e-3));
  SECTION("paused") {
    control.paused = 1;
  }
  SECTION("disarmed") {
    control.armed = 0;
  }
  SECTION("no free pose") {
    set->flags = haptic::kContactNoFreePose;
  }
  SECTION("fault") {
    input.device.V_BH.v.x = std::numeric_limits<double>::quiet_NaN();
  }
  SECTION("a device that is lost, or not homed") {
    input.device.flags =
        GENERATE(values({kDeviceHeld | kDeviceHomed | kDeviceLost, kDeviceHeld + 0u}));
  }
  input.tick = 2, input.t_ns = 2 * kMs;
  CHECK(step_armed(model, state, input).pushes[0].impulse_W.f.z == before);
}

TEST_CASE("servo: a force that is no number pushes nothing", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {0, 0, 1e200})});
  ServoState state;
  const SceneFrame scene = still_scene(1);
  ServoInput input = input_at(1, {}, set.get());
  input.scene = &scene;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  CHECK((f.flags & haptic::kServoFault) != 0);
  CHECK(f.pushes[0].impulse_W == haptic::Wrench{});
}

TEST_CASE("servo: the ticks that it misses push as the last one did, until the device is released",
          "[servo]") {
  const int missed = GENERATE(0, 1, 4, 10, 30);
  const double dt = 1e-3;
  haptic::PushCounters pushes;
  pushes.since_ns = pushes.t_ns = 1'000'000;
  pushes.n = 1;
  pushes.objects[0].impulse_W.f = {0, 0, 5e-3};
  pushes.objects[0].impulse_time_W.f = {0, 0, 2e-3};
  pushes.last_W[0].f = {0, 0, 1e-3};
  // tick by tick
  double J = 5e-3, S = 2e-3;
  for (int k = 1; k <= missed + 1; ++k) {
    S += 1e-3 * J;
    if (k <= std::min(missed, haptic::kReleaseAfterTicks)) J += 1e-3;
  }
  haptic::continue_pushes(pushes, (missed + 2) * kMs, true, dt);
  CAPTURE(missed);
  CHECK(pushes.objects[0].impulse_W.f.z == Approx(J));
  CHECK(pushes.objects[0].impulse_time_W.f.z == Approx(S));
  // a body on an arm that holds a place is not pushed meanwhile
  haptic::PushCounters held;
  held.since_ns = held.t_ns = 1'000'000;
  held.n = 1;
  held.objects[0].impulse_W.f = held.last_W[0].f = {0, 0, 1e-3};
  haptic::continue_pushes(held, (missed + 2) * kMs, false, dt);
  CHECK(held.objects[0].impulse_W.f.z == 1e-3);
}

TEST_CASE("servo: impulses of two objects share the force by their planes", "[servo]") {
  auto set = set_of({plane({1, 0, 0}, {}), plane({0, 1, 0}, {})});
  set->contacts[1].object = 1;
  set->objects.resize(2);
  ServoState state;
  const SceneFrame scene = still_scene(2);
  ServoInput input = input_at(1, {-1e-3, -2e-3, 0}, set.get());
  input.scene = &scene;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  REQUIRE(f.pushes.size() == 2);
  CHECK_THAT(f.pushes[0].impulse_W.f, IsNear({-1e-3, 0, 0}, 1e-15));
  CHECK_THAT(f.pushes[1].impulse_W.f, IsNear({0, -2e-3, 0}, 1e-15));
}

TEST_CASE("servo: what no push can move is counted nowhere, whatever the scene claims", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  set->contacts[0].object = 1;
  set->objects.resize(2);
  const auto [n_objects, response] = GENERATE(table<uint32_t, uint32_t>(
      {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {2, kMaxBodies}, {2, kNoResponse}}));
  SceneFrame scene = still_scene(n_objects);
  if (n_objects > 1) scene.objects[1].response = response;
  ServoState state;
  ServoInput input = input_at(1, {0, 0, -1e-3}, set.get());
  // before a scene has come nothing is known to move
  step_armed(plain_model(1000), state, input);
  CHECK(state.pushes.n == 0);
  CHECK(state.pushes.objects[1].impulse_W == haptic::Wrench{});
  input.scene = &scene;
  input.tick = 2, input.t_ns = 2 * kMs;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  CAPTURE(n_objects, response);
  CHECK(f.F_device_B.f.z == Approx(1));
  REQUIRE(f.pushes.size() == n_objects);
  for (uint32_t k = 0; k < n_objects; ++k) {
    const bool is_counted = n_objects > 1 && k == response;
    CHECK(f.pushes[k].impulse_W.f.z == (is_counted ? Approx(-1e-3) : Approx(0)));
  }
  CHECK(f.forgotten_impulse_W == Vec3{});
}

TEST_CASE("servo: a sample that jumps does not take the tool with it", "[servo]") {
  // contact follows the frame's tool: led around an object, it would pull the hand through
  ServoState state;
  const ServoModel model = plain_model(1000);
  const Vec3 hand_W{0, 0, -1e-3}, elsewhere_W{-0.67, 0, 0};
  for (int64_t k = 1; k <= 3; ++k) step_armed(model, state, input_at(k, hand_W, nullptr));
  for (const auto& [tick, p_W] : {std::pair<int64_t, Vec3>{4, elsewhere_W}, {5, hand_W}}) {
    const ServoFrame f = step_armed(model, state, input_at(tick, p_W, nullptr));
    CHECK(f.fault == static_cast<uint32_t>(haptic::Fault::kPoseJump));
    CHECK(f.X_WT.p == hand_W);
    CHECK(f.V_WT == haptic::Twist{});
    CHECK(f.device.X_BH.p == p_W);
  }
  const Vec3 moved_W{0, 0, -2e-3};
  CHECK(step_armed(model, state, input_at(6, moved_W, nullptr)).X_WT.p == moved_W);
}

TEST_CASE("servo: before somebody has said that it may, nothing is felt", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  ServoState state;
  const ServoFrame f = servo_step(plain_model(1000), state, input_at(1, {0, 0, -1e-3}, set.get()));
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK((f.flags & haptic::kServoDisarmed) != 0);
  // and without contacts there is none to start with
  ServoState alone;
  const ServoFrame g = step_armed(plain_model(1000), alone, input_at(1, {}, nullptr));
  CHECK((g.flags & haptic::kServoNoContactSet) != 0);
  CHECK(alone.safety.gain == 0);
}

TEST_CASE("servo: a fault outlives its servo, and an old request clears nothing", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  const ServoModel model = plain_model(1000);
  haptic::ControlFrame control{};
  control.armed = 1;
  control.translational_stiffness = 1000;
  control.fault_clears = 3;
  control.fault = static_cast<uint32_t>(haptic::Fault::kPoseJump);
  ServoState state;
  int64_t k = 1;
  const auto step = [&] {
    ServoInput input = input_at(k++, {0, 0, -1e-3}, set.get());
    input.control = &control;
    return servo_step(model, state, input);
  };
  for (int i = 0; i < 3; ++i) {
    const ServoFrame f = step();
    CHECK(f.fault == control.fault);
    CHECK(f.F_device_B == haptic::Wrench{});
  }
  // the former servo's requests are done; a new request is not
  control.fault_clears = 4;
  CHECK(step().fault == 0);
  CHECK(step().F_device_B.f.z > 0);
}

TEST_CASE("servo: force only while the dead-man button is held", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  ServoModel model = plain_model(1000);
  model.dead_man_button = 2;
  ServoState state;
  int64_t k = 1;
  const auto force = [&](uint32_t buttons) {
    ServoInput input = input_at(k++, {0, 0, -1e-3}, set.get());
    input.device.buttons = buttons;
    return step_armed(model, state, input).F_device_B.f.z;
  };
  CHECK(force(0) == 0);
  CHECK(force(0b011) == 0);
  CHECK(force(0b100) == Approx(1));
  CHECK(force(0) == 0);
}

TEST_CASE("servo: contradictory planes are flagged and stay finite", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {0, 0, 1e-3}), plane({0, 0, -1}, {0, 0, -1e-3})});
  ServoState state;
  const ServoFrame f = step_armed(plain_model(1000), state, input_at(1, {}, set.get()));
  CHECK((f.flags & haptic::kServoSolverLimit) != 0);
  CHECK(is_finite(f.F_device_B));
}

TEST_CASE("servo: 64 random contacts always give a finite bounded wrench", "[servo][property]") {
  auto set = std::make_unique<ContactSet>();
  ServoModel model = plain_model(5000);
  model.limits.max_force = 6;
  uint64_t seed = 1;
  auto uniform = [&] {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(seed >> 11) * 0x1p-52 - 1;
  };
  ServoState state;
  for (int64_t k = 1; k < 2000; ++k) {
    *set = {};
    set->contacts.resize(haptic::kMaxContacts);
    set->objects.resize(1);
    set->answers_t_ns = (k - 1) * kMs;
    set->seq = static_cast<uint64_t>(k);
    for (Contact& c : set->contacts) {
      c = plane(haptic::normalized(Vec3{uniform(), uniform(), uniform()}),
                0.01 * Vec3{uniform(), uniform(), uniform()}, 0.01 * std::fabs(uniform()));
    }
    const ServoFrame f = step_armed(
        model, state, input_at(k, 0.02 * Vec3{uniform(), uniform(), uniform()}, set.get()));
    REQUIRE(is_finite(f.F_device_B));
    REQUIRE(norm(f.F_device_B.f) <= 6);
  }
}

TEST_CASE("servo: the limits are the smaller of the device's and the configuration's", "[servo]") {
  haptic::SessionConfig config;
  config.safety.max_force = 6;
  CHECK(haptic::build_servo_model(config, {8, 0}).limits.max_force == 6);
  CHECK(haptic::build_servo_model(config, {3, 0}).limits.max_force == 3);
  config.safety.max_torque = 0.2;
  CHECK(haptic::build_servo_model(config, {8, 0.5}).limits.max_torque == 0.2);
  config.safety.torque_slew = 30;
  config.safety.angular_velocity_limit = 12;
  config.device.continuous_torque = 0.05;
  config.device.max_rotational_damping = 0.03;
  config.device.workspace_turn = 1.2;
  config.device.workspace_rest_B = haptic::from_rotation_vector({0, 0.3, 0});
  const haptic::SafetyLimits limits = haptic::build_servo_model(config, {8, 0.15}).limits;
  CHECK(limits.max_torque == 0.15);
  CHECK(limits.torque_slew == 30);
  CHECK(limits.angular_velocity_limit == 12);
  CHECK(limits.continuous_torque == 0.05);
  CHECK(limits.max_rotational_damping == 0.03);
  CHECK(limits.workspace_turn == 1.2);
  CHECK(limits.workspace_rest_B == config.device.workspace_rest_B);
}

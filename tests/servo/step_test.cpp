// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/step.cpp and servo/solve/point_proxy.cpp on hand-made contacts.
#include "servo/step.h"

#include <limits>
#include <memory>
#include <vector>

#include "servo/solve/point_proxy.h"
#include "tests/support/near.h"

using haptic::Contact;
using haptic::ContactSet;
using haptic::PointProxySolution;
using haptic::Pose;
using haptic::SceneFrame;
using haptic::ServoFrame;
using haptic::ServoInput;
using haptic::ServoModel;
using haptic::ServoState;
using haptic::Vec3;
using haptic::test::IsNear;

namespace {

constexpr int64_t kMs = 1'000'000;

Contact plane(const Vec3& normal_O, const Vec3& point_O, double extent = 0.02) {
  Contact c{};
  c.normal_O = c.shading_normal_O = normal_O;
  c.object_point_O = point_O;
  c.extent = extent;
  return c;
}

std::unique_ptr<ContactSet> set_of(std::initializer_list<Contact> contacts) {
  auto set = std::make_unique<ContactSet>();
  *set = {};
  for (const Contact& c : contacts) set->contacts[set->n_contacts++] = c;
  set->n_active = set->n_contacts;
  set->n_objects = 1;
  return set;
}

ServoModel plain_model(double stiffness) {
  ServoModel model;
  model.coupling = {stiffness, 0};
  model.limits.max_force = 100;
  model.limits.max_torque = 1;
  model.limits.soft_start = 0;
  model.limits.slew = 1e9;
  return model;
}

ServoInput input_at(int64_t tick, const Vec3& p_W, const ContactSet* set) {
  ServoInput input;
  input.tick = static_cast<uint64_t>(tick);
  input.t_ns = tick * kMs;
  input.device.X_BH.p = p_W;
  input.device.flags = haptic::kDeviceFresh | haptic::kDeviceHomed;
  input.contacts = set;
  return input;
}

/// One tick of a session that is armed and leaves the coupling as it is.
ServoFrame step_armed(const ServoModel& model, ServoState& state, ServoInput input) {
  haptic::ControlFrame control{};
  control.armed = 1;
  control.translational_stiffness = model.coupling.translational_stiffness;
  control.translational_damping = model.coupling.translational_damping;
  if (input.control == nullptr) input.control = &control;
  return servo_step(model, state, input);
}

}  // namespace

TEST_CASE("servo: plane force is k times depth, exact", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {0.01, 0.02, 0.003})});
  ServoState state;
  const ServoFrame f =
      step_armed(plain_model(900), state, input_at(1, {0.013, 0.018, 0.0013}, set.get()));
  CHECK(norm(f.F_device_B.f - Vec3{0, 0, 900 * (0.003 - 0.0013)}) <=
        haptic::test::tol(1e-9) * 1.53);
  CHECK(f.F_device_B.f.x == 0);
  CHECK(f.F_device_B.f.y == 0);
  CHECK((f.flags & haptic::kServoContact) != 0);
}

TEST_CASE("servo: above the plane there is no force", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {0, 0, 0})});
  ServoState state;
  const ServoFrame f = step_armed(plain_model(900), state, input_at(1, {0, 0, 1e-9}, set.get()));
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK((f.flags & haptic::kServoContact) == 0);
}

TEST_CASE("servo: penalty force is plus k d n (the slide has minus: its normal points in)",
          "[servo][trap]") {
  // algorithms.md 0.4: the force must push the tool out, whatever the plane's direction
  for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, haptic::normalized(Vec3{1, 2, -3})}) {
    const auto set = set_of({plane(n, {})});
    ServoState state;
    const ServoFrame f = step_armed(plain_model(1000), state, input_at(1, -1e-3 * n, set.get()));
    CHECK_THAT(f.F_device_B.f, IsNear(n, 1e-12));
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
  // extents far below the depth: the proxy is in the corner, so both planes hold in full
  const auto set = set_of({plane({1, 0, 0}, {0, 0, 0}, 5e-4), plane({0, 1, 0}, {0, 0, 0}, 5e-4)});
  const PointProxySolution s = solve_point_proxy(*set, {}, {-3e-3, -5e-3, 0}, 1);
  CHECK_THAT(s.proxy_W, IsNear({0, 0, 0}, 1e-15));
}

TEST_CASE("servo: over-constraint trap", "[servo][trap]") {
  const auto set = set_of({plane({0, 1, 0}, {}, 1), plane({0.6, 0.8, 0}, {}, 1)});
  const PointProxySolution s = solve_point_proxy(*set, {}, {0.1, -1, 0}, 1);
  CHECK_THAT(s.proxy_W, IsNear({0.1, 0, 0}, 1e-12));
  CHECK(s.n_active == 1);
}

TEST_CASE("servo: ghost wall trap: beyond its extent a plane gives no force", "[servo][trap]") {
  const auto set = set_of({plane({0, 0, 1}, {}, 1e-3)});
  const double depth = 0.5e-3;
  auto force_at = [&](double x) {
    return 1000 * norm(solve_point_proxy(*set, {}, {x, 0, -depth}, 1).proxy_W - Vec3{x, 0, -depth});
  };
  CHECK(force_at(0.9e-3) == Approx(0.5));
  CHECK(force_at(1.2e-3) == 0);
  // in between it falls without a step: 1 µm of motion changes it by at most 1 % of the full force
  for (int k = 0; k < 300; ++k) {
    const double x = 0.9e-3 + 1e-6 * k;
    CHECK(std::fabs(force_at(x + 1e-6) - force_at(x)) <= 0.5 * 0.0101);
  }
}

TEST_CASE("servo: contacts move with their object", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  SceneFrame scene{};
  scene.n_objects = 1;
  scene.t_ns = 100 * kMs;
  scene.X_WO[0].p = {0, 0, 0.01};
  scene.V_WO[0].v = {0, 0, 1};
  ServoState state;
  // 5 ms after the scene frame the surface is 5 mm higher
  ServoInput input = input_at(105, {0, 0, 0.014}, set.get());
  input.scene = &scene;
  set->answers_t_ns = 104 * kMs;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  CHECK(f.F_device_B.f.z == Approx(1.0));
  CHECK(f.object_impulse_W[0].f.z == Approx(-1.0 * 1e-3));
}

TEST_CASE("servo: a dead sim freezes the scene after 20 ms", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  SceneFrame scene{};
  scene.n_objects = 1;
  scene.t_ns = 100 * kMs;
  scene.V_WO[0].v = {0, 0, 0.1};
  ServoState state;
  ServoInput input = input_at(1100, {0, 0, 0}, set.get());
  input.scene = &scene;
  set->answers_t_ns = 1099 * kMs;
  const ServoFrame f = step_armed(plain_model(1000), state, input);
  CHECK(f.depth == Approx(0.1 * 0.020));

  // what stands still does not push the damper either
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
  // contacts answer until 100 ms, stop for 200 ms and come back
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
  scene.n_objects = 1;
  scene.t_ns = 2 * kMs;
  SECTION("object position") {
    scene.X_WO[0].p.z = std::numeric_limits<double>::quiet_NaN();
    input.scene = &scene;
  }
  SECTION("object velocity") {
    scene.V_WO[0].v.z = std::numeric_limits<double>::infinity();
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

  // the set that says kContactReseeded was overwritten: only its count is left
  set->reseeds = 1;
  set->seq = 2;
  input.tick = 2, input.t_ns = 2 * kMs;
  CHECK(step_armed(model, state, input).F_device_B.f.z == 0);
  // one start a placing, and none for a restarted contact that took the proxy up where it was
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
  ServoInput input = input_at(1, {0, 0, -1e-3}, set.get());
  input.control = &control;
  const double before = step_armed(model, state, input).object_impulse_W[0].f.z;
  CHECK(before == Approx(-1e-3));
  SECTION("paused") {
    control.paused = 1;
  }
  SECTION("no free pose") {
    set->flags = haptic::kContactNoFreePose;
  }
  SECTION("fault") {
    input.device.V_BH.v.x = std::numeric_limits<double>::quiet_NaN();
  }
  input.tick = 2, input.t_ns = 2 * kMs;
  CHECK(step_armed(model, state, input).object_impulse_W[0].f.z == before);
}

TEST_CASE("servo: impulses of two objects share the force by their planes", "[servo]") {
  auto set = set_of({plane({1, 0, 0}, {}), plane({0, 1, 0}, {})});
  set->contacts[1].object = 1;
  set->n_objects = 2;
  ServoState state;
  const ServoFrame f =
      step_armed(plain_model(1000), state, input_at(1, {-1e-3, -2e-3, 0}, set.get()));
  CHECK_THAT(f.object_impulse_W[0].f, IsNear({-1e-3, 0, 0}, 1e-15));
  CHECK_THAT(f.object_impulse_W[1].f, IsNear({0, -2e-3, 0}, 1e-15));
}

TEST_CASE("servo: NaN in the device sample or in a contact gives zero and a latched fault",
          "[servo]") {
  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  const bool in_contact = GENERATE(true, false);
  auto set = set_of({plane({0, 0, 1}, {})});
  ServoState state;
  const ServoModel model = plain_model(1000);
  step_armed(model, state, input_at(1, {0, 0, -1e-3}, set.get()));
  ServoInput input = input_at(2, {0, 0, -1e-3}, set.get());
  if (in_contact) {
    set->contacts[0].normal_O.z = bad;
  } else {
    input.device.X_BH.p.y = bad;
  }
  const ServoFrame f = step_armed(model, state, input);
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK((f.flags & haptic::kServoFault) != 0);
  CHECK(is_finite(f.X_WT));
  CHECK(is_finite(f.X_WP));

  set->contacts[0].normal_O.z = 1;
  const ServoFrame after = step_armed(model, state, input_at(3, {0, 0, -1e-3}, set.get()));
  CHECK(after.F_device_B == haptic::Wrench{});
}

TEST_CASE("servo: a sample that jumps does not take the tool with it", "[servo]") {
  // contact follows the tool of the frame: led round an object, it would pull the hand through
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
  // and without contacts there is nothing to begin with
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
  // what the former servo was told is done; a new request is not
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

TEST_CASE("servo: a device that was let go is pushed from zero", "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  ServoModel model = plain_model(1000);
  model.limits.slew = 100;
  ServoState state;
  const auto force = [&](int64_t tick, bool released) {
    ServoInput input = input_at(tick, {0, 0, -1e-3}, set.get());
    input.released = released;
    set->seq = input.tick;
    set->answers_t_ns = input.t_ns;
    return step_armed(model, state, input).F_device_B.f.z;
  };
  for (int64_t k = 1; k <= 20; ++k) force(k, false);
  CHECK(force(21, false) == Approx(1));
  CHECK(force(22, true) == Approx(0.1));
  CHECK(force(23, false) == Approx(0.2));
}

TEST_CASE("servo: nothing is rendered of a device that is lost or not homed, then softly",
          "[servo]") {
  const auto set = set_of({plane({0, 0, 1}, {})});
  ServoModel model = plain_model(1000);
  model.limits.soft_start = 0.1;
  ServoState state;
  const uint32_t bad = GENERATE(haptic::kDeviceHeld | haptic::kDeviceHomed | haptic::kDeviceLost,
                                haptic::kDeviceHeld + 0u);
  int64_t k = 1;
  const auto step = [&](uint32_t flags) {
    ServoInput input = input_at(k++, {0, 0, -1e-3}, set.get());
    set->seq = input.tick;
    set->answers_t_ns = input.t_ns;
    input.device.flags = flags;
    return step_armed(model, state, input);
  };
  const uint32_t good = haptic::kDeviceFresh | haptic::kDeviceHomed;
  for (int i = 0; i < 200; ++i) step(good);
  CHECK(step(good).F_device_B.f.z == Approx(1));
  for (int i = 0; i < 10; ++i) {
    const ServoFrame f = step(bad);
    CHECK(f.F_device_B == haptic::Wrench{});
    CHECK((f.flags & haptic::kServoNoDevice) != 0);
    CHECK(f.object_impulse_W[0].f.z == step(bad).object_impulse_W[0].f.z);
  }
  // one sample that is missing is no loss
  CHECK(step(good).F_device_B == haptic::Wrench{});
  CHECK(step(good).F_device_B.f.z == Approx(0.01));
  for (int i = 0; i < 200; ++i) step(good);
  CHECK(step(haptic::kDeviceHeld | haptic::kDeviceHomed).F_device_B.f.z == Approx(1));
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
    set->n_contacts = haptic::kMaxContacts;
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

/// That it is held in place until its proxy rests.
ServoFrame settled(const ServoModel& model, const ContactSet& set, const Vec3& p_W) {
  ServoState state;
  ServoFrame f{};
  for (int64_t k = 1; k <= 2000; ++k) {
    ContactSet now = set;
    now.seq = static_cast<uint64_t>(k);
    now.answers_t_ns = (k - 1) * kMs;
    f = step_armed(model, state, input_at(k, p_W, &now));
  }
  return f;
}

}  // namespace

TEST_CASE("servo: a tool with six degrees of freedom feels coupling and contact in series",
          "[servo]") {
  // algorithms.md 7.2: k_vc k_c/(k_vc + k_c) times the depth; direct: k_c alone
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
  // the object was pushed the other way, over two seconds
  if (solver != SoftSolver::kPenaltyDynamics) {
    CHECK(f.object_impulse_W[0].f.z == Approx(-2 * k * depth).epsilon(2e-3));
  }
}

TEST_CASE("servo: a contact beside the tool's origin turns it, about the grip", "[servo]") {
  const double k_c = 3000, depth = 1e-3, arm = 0.01;
  const auto set = soft_set({arm, 0, 0}, k_c);
  ServoModel model = plain_model(800);
  model.proxy.solver = haptic::SoftSolver::kDirect;
  const ServoFrame f = settled(model, *set, {0, 0, -depth});
  CHECK_THAT(f.F_coupling_W.t, IsNear({0, -arm * k_c * depth, 0}, 1e-12));
  // the handle is 5 cm beside the tool: the force has that arm as well
  model.map.X_HT.p = {0.05, 0, 0};
  const ServoFrame held = settled(model, *set, {-0.05, 0, -depth});
  CHECK_THAT(held.F_device_B.t, IsNear({0, -(0.05 + arm) * k_c * depth, 0}, 1e-12));
}

TEST_CASE("servo: a free tool with six degrees of freedom feels exactly nothing", "[servo]") {
  const auto set = soft_set({}, 3000);
  ServoModel model = plain_model(800);
  model.coupling.rotational_stiffness = 1;
  const ServoFrame f = settled(model, *set, {0.003, 0.001, 0.02});
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK(f.X_WP == f.X_WT);
}

TEST_CASE("servo: contacts of a tool that are not finite are a fault", "[servo]") {
  auto set = soft_set({}, std::numeric_limits<double>::quiet_NaN());
  ServoState state;
  const ServoFrame f = step_armed(plain_model(800), state, input_at(1, {0, 0, -1e-3}, set.get()));
  CHECK(f.F_device_B == haptic::Wrench{});
  CHECK(f.fault == static_cast<uint32_t>(haptic::Fault::kContactsNotFinite));
}

TEST_CASE("servo: a point that takes over from a body begins anew", "[servo][trap]") {
  // many contacts of a body must not be taken for features of a point
  auto soft = soft_set({}, 3000);
  for (uint32_t i = 1; i < 8; ++i) soft->contacts[soft->n_contacts++] = soft->contacts[0];
  ServoModel model = plain_model(800);
  model.limits.slew = 1;
  ServoState state;
  step_armed(model, state, input_at(1, {0, 0, -1e-3}, soft.get()));
  CHECK(state.body_pushed);
  CHECK(state.n_active == 0);
  const auto hard = set_of({plane({0, 0, 1}, {})});
  const ServoFrame f = step_armed(model, state, input_at(2, {0, 0, -1e-3}, hard.get()));
  CHECK_FALSE(state.body_pushed);
  // what appears is new, so it slews
  CHECK((f.flags & haptic::kServoSlewing) != 0);
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
    CHECK(state.body.started);
    CHECK(f.X_WP.p.z > -1e-3);
  }
  control.paused = 1;
  ServoInput paused = input_at(21, {0, 0, -2e-3}, set.get());
  paused.control = &control;
  CHECK(step_armed(model, state, paused).F_device_B == haptic::Wrench{});
  CHECK_FALSE(state.body.started);
}

TEST_CASE("servo: what the objects are pushed with is what the hand feels", "[servo]") {
  using haptic::SoftSolver;
  const SoftSolver solver =
      GENERATE(SoftSolver::kDirect, SoftSolver::kPenaltyDynamics, SoftSolver::kQuasiStatic);
  // a linearised wrench that says more than the springs, of which quasi-static knows nothing
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
  for (int64_t k = 1; k <= 3000; ++k) {
    before = state.object_impulse_W[0];
    f = step_armed(model, state, input_at(k, {0, 0, -1e-3}, set.get()));
  }
  const haptic::Wrench pushed = state.object_impulse_W[0];
  CHECK_THAT((pushed.f - before.f) / 1e-3, IsNear(-f.F_coupling_W.f, 1e-6));
}

TEST_CASE("servo: a huge torque is a fault, as a huge force is", "[servo]") {
  const auto set = soft_set({100, 0, 0}, 1e6);
  ServoModel model = plain_model(800);
  model.proxy.solver = haptic::SoftSolver::kDirect;
  model.limits.max_force = 1e9;
  ServoState state;
  const ServoFrame f = step_armed(model, state, input_at(1, {0, 0, -1e-3}, set.get()));
  CHECK(f.fault == static_cast<uint32_t>(haptic::Fault::kForceHuge));
  CHECK(f.F_device_B == haptic::Wrench{});
}

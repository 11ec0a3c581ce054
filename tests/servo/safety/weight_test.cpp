// SPDX-License-Identifier: GPL-3.0-or-later
// The weight of an arm as the servo holds it up: how it comes and goes, what bounds it, what ends
// it. The arm is a mass of the test's own.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kWeight = 1.5;  // [N]
const Wrench kHolding{{0, 0, kWeight}, {0, 0.02, 0}};

/// A session without objects, or with a floor, whose device says what holds it up.
struct HeldSession {
  ServoModel model = plain_model(500);
  ServoState state;
  ControlFrame control{};
  Wrench holding_B = kHolding;
  std::unique_ptr<ContactSet> set = set_of({});
  int64_t k = 0;

  HeldSession() {
    control.armed = 1;
    control.translational_stiffness = 500;
    model.limits.max_force = 4;
    model.limits.max_torque = 0.1;
  }
  ServoInput input(const Vec3& p_B) {
    set->answers_tick = static_cast<uint64_t>(k);
    set->answers_t_ns = k * kMs;
    ++set->seq;
    ServoInput in = input_at(++k, p_B, set.get());
    in.control = &control;
    in.holding_B = holding_B;
    return in;
  }
  ServoFrame step(const Vec3& p_B = {}, const Vec3& v_B = {}) {
    ServoInput in = input(p_B);
    in.device.V_BH.v = v_B;
    return servo_step(model, state, in);
  }
  ServoFrame run(int ticks) {
    for (int i = 1; i < ticks; ++i) step();
    return step();
  }
};

}  // namespace

TEST_CASE("weight: it comes within a second, and is then what the device says", "[servo]") {
  HeldSession s;
  Wrench before = s.step().F_device_B;
  CHECK(before.f.z < 2e-3 * kWeight);
  for (int i = 0; i < 1100; ++i) {
    const Wrench now = s.step().F_device_B;
    REQUIRE(now.f.z - before.f.z < 1.01e-3 * kWeight);
    REQUIRE(now.f.z >= before.f.z);
    before = now;
  }
  CHECK_THAT(before.f, IsNear(kHolding.f, kAlgebra));
  CHECK_THAT(before.t, IsNear(kHolding.t, kAlgebra));
  s.model.limits.max_torque = 0;
  const ServoFrame without = s.step();
  CHECK(without.F_device_B.t == Vec3{});
  CHECK((without.flags & kServoTorqueDropped) == 0);
}

TEST_CASE("weight: a pause and disarming let it go within a second, evenly", "[servo]") {
  HeldSession s;
  s.run(1100);
  (GENERATE(false, true) ? s.control.paused : s.control.armed) ^= 1;
  for (int i = 1; i <= 1000; ++i) {
    REQUIRE(s.step().F_device_B.f.z == Approx(kWeight * (1000 - i) / 1000.0).margin(1e-9));
  }
  CHECK(s.step().F_device_B == Wrench{});
  s.control.paused = 0;
  s.control.armed = 1;
  CHECK(s.run(500).F_device_B.f.z == Approx(kWeight / 2));
}

TEST_CASE("weight: a fault, a lost device and no number end it at once", "[servo]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  HeldSession s;
  s.run(1100);
  ServoInput in = s.input({});
  const int which = GENERATE(0, 1, 2, 3, 4);
  INFO(which);
  if (which == 0) in.device.X_BH.p.x = kNan;
  if (which == 1) in.device.flags |= kDeviceStale;
  if (which == 2) in.device.flags |= kDeviceLost;
  if (which == 3) in.holding_B.f.y = kNan;
  if (which == 4) in.released = true;
  CHECK(servo_step(s.model, s.state, in).F_device_B == Wrench{});
  if (which < 2) {
    CHECK(s.run(100).F_device_B == Wrench{});
    ++s.control.fault_clears;
  }
  // and then it comes as at the beginning
  CHECK(s.run(500).F_device_B.f.z == Approx(kWeight / 2).epsilon(0.02));
}

TEST_CASE("weight: what the hand feels, its pushes and its energy are as without it", "[servo]") {
  // a hand that presses into a wall and slides on it, ever deeper, twice at once
  HeldSession s, bare;
  bare.holding_B = {};
  const SceneFrame scene = still_scene(1);
  s.set = set_of({plane({1, 0, 0}, {})});
  bare.set = set_of({plane({1, 0, 0}, {})});
  bool cut = false;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p_B{-3e-6 * i, 0, 1e-3 * std::sin(0.01 * i)};
    ServoInput in = s.input(p_B), in_bare = bare.input(p_B);
    in.scene = in_bare.scene = &scene;
    const ServoFrame a = servo_step(s.model, s.state, in);
    const ServoFrame b = servo_step(bare.model, bare.state, in_bare);
    REQUIRE(a.pushes.size() == 1);
    REQUIRE(a.pushes[0].impulse_W == b.pushes[0].impulse_W);
    REQUIRE(s.state.safety.passivity.energy == bare.state.safety.passivity.energy);
    REQUIRE(s.state.safety.held_B == bare.state.safety.held_B);
    const Vec3 own = a.F_device_B.f - b.F_device_B.f;
    REQUIRE(own.z >= 0);
    REQUIRE(own.z <= kWeight * (1 + 1e-12));
    REQUIRE_THAT(own, IsNear({0, 0, own.z}, 1e-9));
    REQUIRE(norm(a.F_device_B.f) <= 4);
    cut |= (a.flags & kServoSaturated) != 0 && i > 1000;
    if ((a.flags & kServoSaturated) != 0) REQUIRE(norm(a.F_device_B.f) > 3.999);
  }
  CHECK(cut);
}

TEST_CASE("weight: it counts in the thermal budget of the motors", "[servo]") {
  HeldSession s;
  s.model.limits.continuous_force = 1;
  double load = 0, largest = 0;
  bool warm = false;
  for (int i = 0; i < 40'000; ++i) {
    const ServoFrame frame = s.step();
    load += 1e-4 * (norm_squared(frame.F_device_B.f) - load);
    largest = std::max(largest, load);
    warm |= (frame.flags & kServoSaturated) != 0;
  }
  CHECK(largest < 1.0001);
  CHECK(warm);
}

namespace {

/// A bare arm, or one in a hand: a mass with Coulomb friction on an upright line, under the servo.
struct BareArm {
  HeldSession session;
  double pull = -kWeight, mass = 0.15, friction = 0.2;
  double z = 0, v = 0;
  bool is_held = false;
  uint32_t flags = 0;

  explicit BareArm(double table) { session.holding_B = {{0, 0, table * kWeight}, {}}; }

  void step(double hand = 0) {
    const ServoFrame frame = session.step({0, 0, z}, {0, 0, v});
    flags = frame.flags;
    constexpr int kParts = 10;
    for (int i = 0; i < kParts && !is_held; ++i) {
      const double force = frame.F_device_B.f.z + pull + hand, h = 1e-3 / kParts;
      const double impulse = mass * v + h * force;
      v = std::fabs(impulse) < h * friction
              ? 0
              : (impulse - std::copysign(h * friction, impulse)) / mass;
      z += h * v;
    }
  }
  bool has_ended() const { return (flags & kServoWeightEnded) != 0; }
};

}  // namespace

TEST_CASE("weight: a bare arm stays where it is let go, in twenty places", "[servo]") {
  BareArm arm(1);
  arm.is_held = true;
  for (int i = 0; i < 1100; ++i) arm.step();
  for (int place = 0; place < 20; ++place) {
    arm.z = -0.05 + 0.005 * place;
    arm.is_held = true;
    for (int i = 0; i < 300; ++i) arm.step();
    arm.is_held = false;
    for (int i = 0; i < 300; ++i) arm.step();
    CHECK(std::fabs(arm.z - (-0.05 + 0.005 * place)) < 1e-6);
    CHECK_FALSE(arm.has_ended());
  }
}

TEST_CASE("weight: an arm that a wrong table throws is let go of", "[servo]") {
  const double table = GENERATE(-1.0, 3.0);
  BareArm arm(table);
  arm.is_held = true;
  for (int i = 0; i < 1500; ++i) arm.step();
  CHECK_FALSE(arm.has_ended());
  arm.is_held = false;
  int ticks = 0;
  for (; ticks < 200 && !arm.has_ended(); ++ticks) arm.step();
  CHECK(ticks < 200);
  CHECK(std::fabs(arm.z) < 22e-3);
  // from then on nothing holds it
  CHECK(arm.session.step({0, 0, arm.z}).F_device_B == Wrench{});
  for (int i = 0; i < 1500; ++i) arm.session.step({0, 0, arm.z});
  CHECK(arm.session.step({0, 0, arm.z}).F_device_B == Wrench{});
  // until a pause, or until a hand lifts it
  if (GENERATE(false, true)) {
    arm.session.control.paused = 1;
    arm.session.step({0, 0, arm.z});
    arm.session.control.paused = 0;
  } else {
    for (int i = 1; i <= 102; ++i) arm.session.step({0, 0, arm.z += 1e-4});
  }
  const ServoFrame again = arm.session.step({0, 0, arm.z});
  CHECK((again.flags & kServoWeightEnded) == 0);
  CHECK(again.F_device_B.f.z * table > 0);
  CHECK(std::fabs(again.F_device_B.f.z) < 0.01 * kWeight * std::fabs(table));
}

TEST_CASE("weight: it is caught while it comes, too", "[servo]") {
  // the arm lies on its stand until it is lifted
  BareArm arm(3);
  int ticks = 0;
  for (; ticks < 1000 && !arm.has_ended(); ++ticks) {
    arm.is_held = arm.session.state.weight.gain * 3 < 1;
    arm.step();
  }
  CHECK(arm.has_ended());
  CHECK(arm.z < 22e-3);
}

TEST_CASE("weight: a hand that leads the arm to and fro is there", "[servo]") {
  // 60 mm up and down: fast and ever wider; fast from rest, with a button down; from rest, in 0.5 s
  const int which = GENERATE(0, 1, 2);
  const bool from_rest = which > 0;
  HeldSession s;
  s.run(1100);
  for (int i = 0; i < 3000; ++i) {
    const double rate = which == 2 ? 6.5 : 15;  // of the stroke [rad/s]
    const double since = 1e-3 * (from_rest ? std::max(i % 1500 - 300, 0) : i);
    const double phase = from_rest ? std::min(rate * since, 2 * kPi) : rate * since;
    const double half = from_rest ? 30e-3 : std::min(30e-3, 1e-5 * i);
    ServoInput in = s.input({0, 0, half * (1 - std::cos(phase))});
    in.device.V_BH.v.z = half * rate * std::sin(phase);
    in.device.buttons = which == 1 ? 1 : 0;
    REQUIRE((servo_step(s.model, s.state, in).flags & kServoWeightEnded) == 0);
  }
}

TEST_CASE("weight: a hand that starts as an arm is thrown misses it until it has rested",
          "[servo]") {
  HeldSession s;
  s.run(1100);
  const auto stroke = [](int i) { return Vec3{0, 0, 0.03 * (1 - std::cos(0.015 * i))}; };
  bool ended = false;
  for (int i = 0; i < 200; ++i) {
    const Vec3 v_B{0, 0, 0.45 * std::sin(0.015 * i)};
    ended |= (s.step(stroke(i), v_B).flags & kServoWeightEnded) != 0;
  }
  CHECK(ended);
  for (int i = 0; i < 300; ++i) s.step(stroke(200));
  for (int i = 0; i <= 1200; ++i) s.step(stroke(200) + Vec3{1e-5 * i, 0, 0});
  const ServoFrame frame = s.step(stroke(200) + Vec3{12e-3, 0, 0});
  CHECK((frame.flags & kServoWeightEnded) == 0);
  CHECK(frame.F_device_B.f.z == Approx(0.2 * kWeight).epsilon(0.05));
}

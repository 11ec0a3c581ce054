// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety/safety.cpp: what holds for force and moving holds for torque and turning.
#include <limits>
#include <random>

#include "servo/safety/safety.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kDt = 1e-3;
constexpr uint32_t kGood = kDeviceFresh | kDeviceHomed;
const double kNaN = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();
const SafetyLimits kLimits{
    .max_force = 5, .max_torque = 0.2, .soft_start = 0, .slew = 1e9, .torque_slew = 1e9};

/// A handle that is asked for a wrench, tick by tick.
struct Handle {
  SafetyLimits limits = kLimits;
  SafetyState state;
  SafetyInput input;

  Handle() {
    state.gain = 1;
    input.device.flags = kGood | kDeviceOpenLoop;
    input.F_B = {{1, 0, 0}, {0, 0, 0.1}};
    tick();
  }
  SafetyOutput tick(double seconds = kDt) {
    input.now_ns = input.device.t_ns = input.now_ns + static_cast<int64_t>(1e9 * seconds);
    return make_safe(limits, state, input, kDt);
  }
  void turn(const Vec3& turn_B) {
    input.device.X_BH.q = from_rotation_vector(turn_B) * input.device.X_BH.q;
  }
};

/// A fault is zero at once and until it is cleared.
void check_latched(Handle& handle, const SafetyOutput& out, Fault fault) {
  CHECK(out.F_B == Wrench{});
  CHECK(handle.state.fault == fault);
  handle.input.F_B = {{}, {0, 0, 0.1}};
  handle.input.device.flags = kGood | kDeviceOpenLoop;
  CHECK(handle.tick().F_B == Wrench{});
  handle.input.fault_clears = 1;
  CHECK(handle.tick().F_B.t.z == 0.1);
}

}  // namespace

TEST_CASE("safety: each planted fault of torque ends as the force's does", "[servo]") {
  Handle handle;
  CHECK(handle.tick().F_B == handle.input.F_B);
  SECTION("not a number, or infinite") {
    for (const double bad : {kNaN, kInfinity, -kInfinity}) {
      Handle struck;
      struck.input.F_B.t = {0, bad, 0};
      check_latched(struck, struck.tick(), Fault::kForceNotFinite);
    }
  }
  SECTION("huge") {
    for (const double huge : {0.201e3, 1e200, 1.7e308}) {
      Handle struck;
      struck.input.F_B.t = {0, huge, -huge};
      check_latched(struck, struck.tick(), Fault::kForceHuge);
    }
  }
  SECTION("a jump of one radian") {
    handle.turn({0.6, 0, -0.8});
    check_latched(handle, handle.tick(), Fault::kPoseJump);
  }
  SECTION("a device that is stale or noisy") {
    for (const bool stale : {true, false}) {
      Handle struck;
      struck.input.device.flags |= stale ? kDeviceStale : kDeviceNoisy;
      check_latched(struck, struck.tick(), stale ? Fault::kDeviceStale : Fault::kDeviceNoisy);
    }
  }
  SECTION("a large torque is saturated, its direction is kept") {
    handle.input.F_B.t = {0, 3, -4};
    const SafetyOutput out = handle.tick();
    CHECK_THAT(out.F_B.t, IsNear({0, 0.12, -0.16}, 1e-12));
    CHECK(norm(out.F_B.t) <= 0.2);
    CHECK((out.flags & kServoSaturated) != 0);
  }
}

TEST_CASE("safety: an orientation jumps where the hand cannot have turned so far", "[servo]") {
  Handle handle;
  handle.limits.angular_velocity_limit = 20;
  SECTION("as far after a pause in which it can") {
    handle.turn({1, 0, 0});
    CHECK(handle.tick(0.05).F_B.t.z == 0.1);
  }
  SECTION("a hand at the limit, with encoder steps and jitter, does not") {
    for (int k = 1; k < 1000; ++k) {
      handle.turn({0, 0, 0.02 + (k % 2 == 0 ? 5e-3 : -5e-3)});
      handle.tick(kDt + (k % 2 == 0 ? 2e-4 : -2e-4));
      REQUIRE(handle.state.fault == Fault::kNone);
    }
  }
  SECTION("the same rotation as another quaternion is none") {
    const Quat q = handle.input.device.X_BH.q;
    handle.input.device.X_BH.q = {-q.x, -q.y, -q.z, -q.w};
    CHECK(handle.tick().F_B.t.z == 0.1);
  }
  SECTION("where turning is not felt it is no fault; with the tool off the handle it is") {
    handle.limits.max_torque = 0;
    handle.turn({1, 0, 0});
    CHECK(handle.tick().F_B.f.x == 1);
    handle.input.stiffness.turning = 80;
    handle.turn({1, 0, 0});
    CHECK(handle.tick().F_B == Wrench{});
    CHECK(handle.state.fault == Fault::kPoseJump);
  }
}

TEST_CASE("safety: turning too fast is zero until the hand is calm in both", "[servo]") {
  Handle handle;
  handle.limits.soft_start = 0.1;
  const auto at = [&](double speed, double turning) {
    handle.input.device.V_BH = {{0, speed, 0}, {turning, 0, 0}};
    return handle.tick();
  };
  CHECK(at(1.9, 19.9).F_B == handle.input.F_B);
  const SafetyOutput fast = at(0, 20.1);
  CHECK(fast.F_B == Wrench{});
  CHECK((fast.flags & kServoTooFast) != 0);
  CHECK((at(0, 1.1).flags & kServoTooFast) != 0);
  CHECK((at(0.11, 0.9).flags & kServoTooFast) != 0);
  CHECK(at(0.09, 0.9).F_B == Wrench{});
  CHECK(at(0.09, 0.9).F_B.t.z == Approx(0.1 * 0.01));
  // moving too fast reopens no sooner
  at(2.1, 0);
  CHECK((at(0, 1.1).flags & kServoTooFast) != 0);
  // nor is a fault cleared while the hand turns
  handle.input.F_B.t.z = kNaN;
  at(0, 0);
  handle.input.F_B.t.z = 0.1;
  handle.input.fault_clears = 1;
  CHECK((at(0, 1.1).flags & kServoFault) != 0);
  CHECK((at(0, 0.9).flags & kServoFault) == 0);
}

TEST_CASE("safety: whatever is asked for, no torque grows by more than slew and hand allow",
          "[servo][property]") {
  // any wrench, any motion of the hand below the limits, a tool off the handle or on it
  std::mt19937 rng(20);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&](double most) { return most * Vec3{unit(rng), unit(rng), unit(rng)}; };
  const double lever = GENERATE(0.0, 0.05);
  const double stiffness = 800, rotational = 1.5, slew = 500, torque_slew = 15;
  Handle handle;
  handle.limits.slew = slew;
  handle.limits.torque_slew = torque_slew;
  handle.input.stiffness = {stiffness, lever * stiffness, rotational, lever};
  handle.input.surface_turning_B = {0, 2, 0};
  double largest = 0;
  Vec3 last;
  handle.state.held_B = {};
  for (int k = 0; k < 20'000; ++k) {
    if (k % 3 != 0) handle.input.F_B = {any(20), any(1)};
    const Vec3 step = any(1e-3), turn = any(8e-3);
    handle.input.device.X_BH.p += step;
    handle.turn(turn);
    handle.input.device.flags = k > 10'000 ? kGood | kDeviceOpenLoop : kGood;
    const Vec3 torque = handle.tick().F_B.t;
    const double way = norm(step), angle = norm(turn);
    const double force_grows = slew * kDt + stiffness * way + lever * stiffness * angle;
    const double most = torque_slew * kDt + rotational * angle + lever * force_grows;
    // in any direction: any part of the previous torque may remain
    const double length2 = norm_squared(last);
    const double share = length2 > 0 ? std::clamp(dot(torque, last) / length2, 0.0, 1.0) : 0;
    CAPTURE(k, norm(torque), norm(last), angle);
    REQUIRE(norm(torque - share * last) <= most * (1 + 1e-9));
    REQUIRE(norm(torque) <= handle.limits.max_torque);
    largest = std::max(largest, norm(torque));
    last = torque;
  }
  CHECK(handle.state.fault == Fault::kNone);
  CHECK(largest > 0.7 * handle.limits.max_torque);
}

TEST_CASE("safety: the torque's slew is its own, and counts the time that has passed", "[servo]") {
  Handle handle;
  handle.limits.torque_slew = 20;
  handle.state.held_B = {};
  handle.input.F_B = {{}, {0, 0, 0.2}};
  const SafetyOutput first = handle.tick();
  CHECK(first.F_B.t.z == Approx(0.02));
  CHECK((first.flags & kServoSlewing) != 0);
  // a tick that is late counts as one, the next, 0.4 ms later, as 0.4
  CHECK(handle.tick(10.6e-3).F_B.t.z == Approx(0.04));
  CHECK(handle.tick(0.4e-3).F_B.t.z == Approx(0.048));
  // it shrinks at once
  handle.input.F_B.t.z = 0.01;
  CHECK(handle.tick().F_B.t.z == 0.01);
  // without one of its own, as long to its limit as the force to its own
  handle.limits.torque_slew = 0;
  handle.limits.slew = 1000;
  handle.input.F_B.t.z = 0.2;
  CHECK(handle.tick().F_B.t.z == Approx(0.01 + 0.2 / 5));
}

TEST_CASE("safety: a slap or a twist against a stiff wall is not slowed", "[servo]") {
  // the tool is off the handle: force and torque grow with the way and the turn of the hand
  const double stiffness = 3000, rotational = 4, lever = 0.05;
  Handle handle;
  handle.limits = {
      .max_force = 40, .max_torque = 3, .soft_start = 0, .slew = 1, .torque_slew = 0.01};
  handle.input.stiffness = {stiffness, 0, rotational, lever};
  handle.input.F_B = {};
  handle.tick();
  for (int k = 1; k <= 8; ++k) {
    handle.input.device.X_BH.p.z = -1.5e-3 * k;
    handle.turn({15e-3, 0, 0});
    handle.input.F_B.f.z = stiffness * 1.5e-3 * k;
    handle.input.F_B.t = {-rotational * 15e-3 * k, -lever * handle.input.F_B.f.z, 0};
    const SafetyOutput out = handle.tick();
    CAPTURE(k);
    CHECK(out.F_B == handle.input.F_B);
    CHECK((out.flags & kServoSlewing) == 0);
  }
}

TEST_CASE("safety: a torque is let go no faster than it may grow", "[servo]") {
  Handle handle;
  handle.limits.torque_slew = 1;
  handle.input.F_B = {{}, {0, 0, 0.1}};
  handle.input.letting_go = true;
  handle.tick();
  CHECK(handle.tick().F_B.t.z == Approx(0.098));
  for (int k = 0; k < 98; ++k) handle.tick();
  CHECK(handle.tick().F_B.t.z == Approx(0).margin(1e-9));
}

TEST_CASE("safety: a torque that gives energy away is damped, but not where contacts fade",
          "[servo]") {
  Handle handle;
  handle.input.device.flags = kGood;
  handle.limits.max_rotational_damping = 0.002;
  handle.input.F_B = {{}, {0, 0, 0.1}};
  handle.tick();
  // 4 mJ in a tick, at 40 rad/s, where no jump is looked for
  handle.limits.angular_velocity_limit = 100;
  handle.input.fading = GENERATE(false, true);
  handle.turn({0, 0, 0.04});
  const SafetyOutput out = handle.tick();
  CHECK(out.F_B.t.z == Approx(handle.input.fading ? 0.1 : 0.1 - 0.002 * 40));
  CHECK(((out.flags & kServoPassivity) != 0) == !handle.input.fading);
}

TEST_CASE("safety: torque has a thermal budget of its own", "[servo]") {
  Handle handle;
  handle.limits.continuous_torque = 0.05;
  handle.input.F_B = {{4, 0, 0}, {0, 0.3, 0}};
  double last = 0.2, squares = 0;
  const int ticks = 120'000;
  SafetyOutput out;
  for (int k = 0; k < ticks; ++k) {
    out = handle.tick();
    REQUIRE(out.F_B.t.y <= 0.2);
    REQUIRE(last - out.F_B.t.y <= 2e-3);
    // the force keeps its own
    REQUIRE(out.F_B.f.x == 4);
    last = out.F_B.t.y;
    if (k >= ticks / 2) squares += last * last;
  }
  CHECK((out.flags & kServoThermal) != 0);
  CHECK(std::sqrt(2 * squares / ticks) <= 0.05 * 1.001);
  CHECK(last == Approx(0.05).epsilon(0.1));
  handle.input.F_B = {};
  for (int k = 0; k < 60'000; ++k) handle.tick();
  handle.input.F_B.t = {0, 0.3, 0};
  CHECK(handle.tick().F_B.t.y == Approx(0.2));
}

TEST_CASE("safety: the edge of the workspace turns back softly", "[servo]") {
  Handle handle;
  handle.input.F_B = {};
  handle.limits.workspace_rest_B = from_rotation_vector({0, 0, 0.4});
  handle.limits.workspace_turn = 1;
  const Vec3 axis = normalized(Vec3{2, -1, 2});
  const auto at = [&](double angle) {
    handle.state.sample.known = false;
    handle.input.device.X_BH.q =
        from_rotation_vector(angle * axis) * handle.limits.workspace_rest_B;
    return handle.tick();
  };
  CHECK(at(0.999).F_B == Wrench{});
  CHECK_THAT(at(1.025).F_B.t, IsNear(-0.03 * axis, 1e-9));
  CHECK_THAT(at(2).F_B.t, IsNear(-0.06 * axis, 1e-9));
  CHECK((at(2).flags & kServoWorkspaceEdge) != 0);
  // a device without torque has none
  handle.limits.max_torque = 0;
  CHECK(at(2).F_B == Wrench{});
  CHECK((at(2).flags & (kServoWorkspaceEdge | kServoTorqueDropped)) == 0);
}

TEST_CASE("safety: torque changes nothing of the force where there is none", "[servo]") {
  // the same hand and the same forces, once with torques and turns that are not rendered
  std::mt19937 rng(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&](double most) { return most * Vec3{unit(rng), unit(rng), unit(rng)}; };
  Handle plain, turned;
  for (Handle* handle : {&plain, &turned}) {
    handle->limits.max_torque = 0;
    handle->limits.slew = 500;
    handle->limits.torque_slew = 0;
    handle->limits.continuous_force = 2;
    handle->limits.workspace_radius = 0.01;
    handle->limits.workspace_turn = 0.1;
    handle->input.device.flags = kGood;
    handle->input.stiffness.translational = 800;
  }
  for (int k = 0; k < 5000; ++k) {
    plain.input.F_B = {any(8), {}};
    plain.input.device.X_BH.p += any(1e-3);
    turned.input.F_B = {plain.input.F_B.f, any(3)};
    turned.input.device.X_BH.p = plain.input.device.X_BH.p;
    turned.turn(any(0.5));
    turned.input.device.V_BH.w = any(100);
    plain.input.letting_go = turned.input.letting_go = k % 500 > 450;
    const SafetyOutput a = plain.tick(), b = turned.tick();
    REQUIRE(a.F_B.f == b.F_B.f);
    REQUIRE(b.F_B.t == Vec3{});
    REQUIRE((a.flags | kServoTorqueDropped) == (b.flags | kServoTorqueDropped));
  }
  CHECK(plain.state.passivity.energy == turned.state.passivity.energy);
}

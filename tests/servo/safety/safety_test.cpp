// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety/safety.cpp: what holds for force and moving holds for torque and turning,
// so nearly every test is one over both.
#include "servo/safety/safety.h"

#include <algorithm>
#include <limits>

#include "proto/math/units.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr uint32_t kGood = kDeviceFresh | kDeviceHomed;
const double kNaN = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();
// the wrench may step in tests that are not about its growth
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
  }
  SafetyOutput tick(double seconds = kTick) {
    input.now_ns = input.device.t_ns = input.now_ns + static_cast<int64_t>(1e9 * seconds);
    return make_safe(limits, state, input, kTick);
  }
  SafetyOutput ask(const Wrench& F_B) {
    input.F_B = F_B;
    return tick();
  }
  void turn(const Vec3& turn_B) {
    input.device.X_BH.q = from_rotation_vector(turn_B) * input.device.X_BH.q;
  }
};

/// One half of the wrench, and what goes with it. Figures in N and m, or in N·m and rad.
struct Half {
  bool turns = false;
  const char* name = "force";
  double limit = kLimits.max_force;
  Vec3 Wrench::*of = &Wrench::f;
  Vec3 Twist::*velocity = &Twist::v;
  double SafetyLimits::*continuous = &SafetyLimits::continuous_force;
  double SafetyLimits::*slew = &SafetyLimits::slew;
  double SafetyLimits::*damping = &SafetyLimits::max_damping;

  double fast() const { return turns ? 20 : 2; }             // the velocity limit
  double calm() const { return fast() / 20; }                // below it a hand may begin again
  double edge_width() const { return turns ? 0.05 : 5e-3; }  // of the workspace's edge
  /// This half alone, as a share of its limit.
  Wrench share(const Vec3& shares) const {
    Wrench F_B;
    F_B.*of = limit * shares;
    return F_B;
  }
  Wrench share(double x) const { return share(Vec3{x, 0, 0}); }
  Vec3 shares(const SafetyOutput& out) const { return 1 / limit * (out.F_B.*of); }
  void move(Handle& handle, const Vec3& by_B) const {
    turns ? handle.turn(by_B) : void(handle.input.device.X_BH.p += by_B);
  }
};

const Half kForce;
const Half kTorque{true,
                   "torque",
                   kLimits.max_torque,
                   &Wrench::t,
                   &Twist::w,
                   &SafetyLimits::continuous_torque,
                   &SafetyLimits::torque_slew,
                   &SafetyLimits::max_rotational_damping};

Half each_half() {
  return GENERATE(values<Half>({kForce, kTorque}));
}

/// A fault is zero at once and until it is cleared, then there is a soft start from zero.
void check_latched(Handle& handle, const SafetyOutput& out, Fault fault, const Half& half) {
  CHECK(out.F_B == Wrench{});
  CHECK((out.flags & kServoFault) != 0);
  CHECK(handle.state.fault == fault);
  const Wrench F_B = half.share(0.2);
  handle.input.device.flags = kGood | kDeviceOpenLoop;
  CHECK(handle.ask(F_B).F_B == Wrench{});
  handle.limits.soft_start = 0.1;
  ++handle.input.fault_clears;
  const SafetyOutput cleared = handle.tick();
  CHECK((cleared.flags & kServoFault) == 0);
  CHECK(cleared.F_B == Wrench{});
  CHECK(half.shares(handle.tick()).x == Approx(0.2 * 0.01));
  for (int i = 0; i < 100; ++i) handle.tick();
  CHECK(handle.tick().F_B == F_B);
}

}  // namespace

TEST_CASE("safety: a wrench within the limits passes unchanged", "[servo]") {
  Handle handle;
  const Wrench F{{1, -2, 3}, {0.01, 0.02, 0.03}};
  const SafetyOutput out = handle.ask(F);
  CHECK(out.F_B == F);
  CHECK(out.flags == 0);
}

TEST_CASE("safety: saturation keeps the direction", "[servo]") {
  const Half half = each_half();
  const double much = GENERATE(6.0, 999.0);  // not yet a fault
  INFO(half.name);
  Handle handle;
  const Vec3 shares = much * Vec3{3.0 / 13, -4.0 / 13, 1};
  const SafetyOutput out = handle.ask(half.share(shares));
  CHECK_THAT(half.shares(out), IsNear(normalized(shares), 1e-12));
  CHECK((out.flags & kServoSaturated) != 0);
}

TEST_CASE("safety: what is saturated is not above the limit by a single bit", "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  Handle handle;
  Random random(3);
  for (int i = 0; i < 100'000; ++i) {
    const Vec3 shares = random.in_box({-10, -10, -10}, {10, 10, 10});
    REQUIRE(norm(handle.ask(half.share(shares)).F_B.*half.of) <= half.limit);
  }
}

TEST_CASE("safety: what is no wrench, or beyond all reason, latches a fault until it is cleared",
          "[servo]") {
  const Half half = each_half();
  const double bad =
      GENERATE_COPY(values({kNaN, kInfinity, -kInfinity, 1001 * half.limit, 1e200, 1.7e308}));
  CAPTURE(half.name, bad);
  for (int i = 0; i < 3; ++i) {
    Handle handle;
    handle.tick();
    (handle.input.F_B.*half.of)[i] = bad;
    check_latched(handle, handle.tick(),
                  std::isfinite(bad) ? Fault::kForceHuge : Fault::kForceNotFinite, half);
  }
  Handle all;
  all.input.F_B.*half.of = {bad, -bad, bad};
  CHECK(all.tick().F_B == Wrench{});
}

TEST_CASE("safety: each fault names its reason, and the first one stays", "[servo]") {
  Handle handle;
  handle.input.F_B = {{1, 0, 0}, {}};
  handle.input.device_finite = false;
  handle.tick();
  CHECK(handle.state.fault == Fault::kDeviceNotFinite);
  handle.input.device_finite = true;
  handle.input.contacts_finite = false;
  handle.tick();
  CHECK(handle.state.fault == Fault::kDeviceNotFinite);
  handle.state = {};
  handle.tick();
  CHECK(handle.state.fault == Fault::kContactsNotFinite);
}

TEST_CASE("safety: a fault is cleared only while the handle is calm", "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  Handle handle;
  handle.ask(half.share(kNaN));
  handle.input.fault_clears = 1;
  handle.input.device.V_BH.*half.velocity = {1.1 * half.calm(), 0, 0};
  CHECK((handle.ask(half.share(0.2)).flags & kServoFault) != 0);
  // the request waits: it need not be repeated
  handle.input.device.V_BH.*half.velocity = {0.9 * half.calm(), 0, 0};
  CHECK((handle.tick().flags & kServoFault) == 0);
}

TEST_CASE("safety: soft start rises linearly from zero and never steps", "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  Handle handle;
  handle.state.gain = 0;
  handle.limits.soft_start = 0.5;
  double before = 0;
  for (int k = 0; k <= 600; ++k) {
    const double now = half.shares(handle.ask(half.share(0.8))).x;
    CHECK(now == Approx(0.8 * std::min(1.0, k * kTick / 0.5)).margin(1e-12));
    CHECK(now - before <= 0.8 * kTick / 0.5 + 1e-12);
    before = now;
  }
}

TEST_CASE("safety: closed or not armed is zero, and opens through the soft start", "[servo]") {
  const Half half = each_half();
  const bool closes = GENERATE(true, false);
  CAPTURE(half.name, closes);
  Handle handle;
  handle.limits.soft_start = 0.1;
  handle.input.force_closed = closes;
  handle.input.armed = closes;
  const SafetyOutput off = handle.ask(half.share(0.8));
  CHECK(off.F_B == Wrench{});
  CHECK(((off.flags & kServoDisarmed) != 0) == !closes);
  handle.input.force_closed = false;
  handle.input.armed = true;
  CHECK(handle.tick().F_B == Wrench{});
  CHECK(half.shares(handle.tick()).x == Approx(0.008));
}

TEST_CASE("safety: a device without torque motors drops the torque and says so", "[servo]") {
  Handle handle;
  handle.limits.max_torque = 0;
  handle.limits.workspace_turn = 1;
  const SafetyOutput out = handle.ask({{1, 0, 0}, {0, 0, 0.02}});
  CHECK(out.F_B.t == Vec3{});
  CHECK_THAT(out.F_B.f, IsNear({1, 0, 0}, 1e-15));
  CHECK((out.flags & kServoTorqueDropped) != 0);
  CHECK((out.flags & kServoSaturated) == 0);
  // nor has it an edge at which it turns back
  handle.turn({0, 2, 0});
  const SafetyOutput beyond = handle.ask({});
  CHECK(beyond.F_B == Wrench{});
  CHECK((beyond.flags & (kServoWorkspaceEdge | kServoTorqueDropped | kServoFault)) == 0);
}

TEST_CASE("safety: a device whose driver doubts it closes the force until it is cleared",
          "[servo]") {
  const Half half = each_half();
  const bool stale = GENERATE(true, false);
  CAPTURE(half.name, stale);
  const Fault fault = stale ? Fault::kDeviceStale : Fault::kDeviceNoisy;
  Handle handle;
  handle.ask(half.share(0.2));
  handle.input.device.flags |= stale ? kDeviceStale : kDeviceNoisy;
  CHECK(handle.tick().F_B == Wrench{});
  // clear-fault has no effect before it is healthy
  handle.input.fault_clears = 1;
  check_latched(handle, handle.tick(), fault, half);
}

TEST_CASE("safety: a pose that jumps is a fault, over the time that was measured", "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  const Vec3 far{0.6, 0, -0.8};
  Handle handle;
  handle.ask(half.share(0.2));
  const auto feels = [&](const SafetyOutput& out) { return out.F_B == half.share(0.2); };
  SECTION("one metre or radian in a tick; after clearing it is not compared with earlier ones") {
    half.move(handle, far);
    check_latched(handle, handle.tick(), Fault::kPoseJump, half);
  }
  SECTION("the same way after a pause in which it can have been gone") {
    half.move(handle, far);
    CHECK(feels(handle.tick(0.6 / half.fast())));
  }
  SECTION("a sample that is held says nothing") {
    half.move(handle, far);
    handle.input.device.flags = kDeviceHeld | kDeviceHomed | kDeviceOpenLoop;
    CHECK(feels(handle.tick()));
  }
  SECTION("homing, and a device that comes back, move the pose rightly") {
    const uint32_t unknown =
        GENERATE(kDeviceFresh | kDeviceOpenLoop, kGood | kDeviceLost | kDeviceOpenLoop);
    half.move(handle, 0.5 * far);
    handle.input.device.flags = unknown;
    handle.tick();
    half.move(handle, 0.5 * far);
    handle.input.device.flags = kGood | kDeviceOpenLoop;
    handle.tick();
    CHECK(handle.state.fault == Fault::kNone);
  }
  SECTION("a hand at the limit, with encoder steps and jitter, is no jump") {
    for (int k = 1; k < 1000; ++k) {
      const double sign = k % 2 == 0 ? 1 : -1;
      half.move(handle, {0, 0, half.fast() * kTick * (1 + sign / 4)});
      handle.tick(kTick - sign * 4e-4);
      REQUIRE(handle.state.fault == Fault::kNone);
    }
  }
}

TEST_CASE("safety: an orientation jumps only where turning is felt, and as a rotation", "[servo]") {
  Handle handle;
  handle.ask({{1, 0, 0}, {0, 0, 0.1}});
  // the same rotation as another quaternion
  const Quat q = handle.input.device.X_BH.q;
  handle.input.device.X_BH.q = {-q.x, -q.y, -q.z, -q.w};
  CHECK(handle.tick().F_B.t.z == 0.1);
  // with the tool off the handle it is felt without torque too
  handle.limits.max_torque = 0;
  handle.turn({1, 0, 0});
  CHECK(handle.tick().F_B.f.x == 1);
  handle.input.stiffness.turning = 80;
  handle.turn({1, 0, 0});
  CHECK(handle.tick().F_B == Wrench{});
  CHECK(handle.state.fault == Fault::kPoseJump);
}

TEST_CASE("safety: too fast is zero until the hand is calm in both, then a soft start", "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  Handle handle;
  handle.limits.soft_start = 0.1;
  handle.input.F_B = {{1, 0, 0}, {0, 0, 0.1}};
  const auto at = [&](double moving, double turning) {
    handle.input.device.V_BH = {{0, moving, 0}, {turning, 0, 0}};
    return handle.tick();
  };
  CHECK(at(1.99, 19.9).F_B == handle.input.F_B);
  const SafetyOutput fast = half.turns ? at(0, 20.1) : at(2.01, 0);
  CHECK(fast.F_B == Wrench{});
  CHECK((fast.flags & kServoTooFast) != 0);
  CHECK((at(0.5, 0).flags & kServoTooFast) != 0);
  CHECK((at(0, 1.1).flags & kServoTooFast) != 0);
  CHECK((at(0.11, 0.9).flags & kServoTooFast) != 0);
  CHECK(at(0.09, 0.9).F_B == Wrench{});
  const Wrench soft = at(0.09, 0.9).F_B;
  CHECK(soft.f.x == Approx(0.01));
  CHECK(soft.t.z == Approx(0.1 * 0.01));
}

TEST_CASE("safety: what comes grows by the time that has passed, what is held goes at once",
          "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  Handle handle;
  handle.limits.*half.slew = 0.4 * half.limit / kTick;
  const auto ask = [&](const Vec3& shares) { return half.shares(handle.ask(half.share(shares))); };
  SECTION("it shrinks at once, and into a corner the force of the existing wall is unchanged") {
    CHECK_THAT(ask({0.8, 0, 0}), IsNear({0.4, 0, 0}, 1e-12));
    CHECK_THAT(ask({0.8, 0, 0}), IsNear({0.8, 0, 0}, 1e-12));
    CHECK(ask({0.1, 0, 0}).x == Approx(0.1));
    ask({0.4, 0, 0});
    CHECK_THAT(ask({0.4, 0.6, 0}), IsNear({0.4, 0.4, 0}, 1e-12));
    // a wall on the other side
    ask({0.4, 0, 0});
    const SafetyOutput other = handle.ask(half.share(-0.98));
    CHECK_THAT(half.shares(other), IsNear({-0.4, 0, 0}, 1e-12));
    CHECK((other.flags & kServoSlewing) != 0);
  }
  SECTION("a tick that is 10.6 ms late counts as one, the next, 0.4 ms later, as 0.4") {
    handle.ask({});
    handle.input.F_B = half.share(0.98);
    CHECK(half.shares(handle.tick(11.6e-3)).x == Approx(0.4));
    CHECK(half.shares(handle.tick(0.4e-3)).x == Approx(1.4 * 0.4));
    CHECK(half.shares(handle.tick()).x == Approx(2.4 * 0.4));
  }
  SECTION("after a release from outside it rises from zero") {
    for (int k = 0; k < 2; ++k) ask({0.8, 0, 0});
    CHECK(handle.state.held_B == half.share(0.8));
    handle.input.released = true;
    const SafetyOutput first = handle.tick();
    CHECK(half.shares(first).x == Approx(0.4));
    CHECK((first.flags & kServoSlewing) != 0);
    handle.input.released = false;
    CHECK(half.shares(handle.tick()).x == Approx(0.8));
  }
  SECTION("what is let go falls no faster than it may grow") {
    handle.limits.*half.slew = 0.005 * half.limit / kTick;
    handle.state.held_B = half.share(0.5);
    handle.input.letting_go = true;
    ask({0.5, 0, 0});
    CHECK(half.shares(handle.tick()).x == Approx(0.49));
    for (int k = 0; k < 98; ++k) handle.tick();
    CHECK(half.shares(handle.tick()).x == Approx(0).margin(1e-9));
  }
}

TEST_CASE("safety: whatever is asked for, no tick grows by more than slew and hand allow",
          "[servo][property]") {
  // any wrench, any motion of the hand below the limits, a tool off the handle or on it, closed
  // loop or open
  Random random(15);
  const auto any = [&](double most) {
    return random.in_box({-most, -most, -most}, {most, most, most});
  };
  const double lever = GENERATE(0.0, 0.05);
  const double stiffness = 800, rotational = 1.5;
  Handle handle;
  handle.limits.slew = lever > 0 ? 500 : 2000;
  handle.limits.torque_slew = 15;
  handle.input.stiffness = {stiffness, lever * stiffness, rotational, lever};
  handle.input.surface_B = {{0.1, 0, 0}, {0, 2, 0}};
  handle.tick();
  Wrench last;
  double strongest = 0, hardest = 0;
  // in any direction: any part of the previous force or torque may remain
  const auto growth = [](const Vec3& now, const Vec3& before) {
    const double length2 = norm_squared(before);
    const double share = length2 > 0 ? std::clamp(dot(now, before) / length2, 0.0, 1.0) : 0;
    return norm(now - share * before);
  };
  for (int k = 0; k < 20'000; ++k) {
    // a lie, a lasting lie, or the truth
    if (k % 3 != 0) handle.input.F_B = {any(20), any(1)};
    const Vec3 step = any(1e-3), turn = any(8e-3);
    handle.input.device.X_BH.p += step;
    handle.turn(turn);
    handle.input.device.flags = k > 10'000 ? kGood | kDeviceOpenLoop : kGood;
    const Wrench now = handle.tick().F_B;
    const double force =
        handle.limits.slew * kTick + stiffness * norm(step) + lever * stiffness * norm(turn);
    const double torque =
        handle.limits.torque_slew * kTick + rotational * norm(turn) + lever * force;
    CAPTURE(k, lever, norm(step), norm(turn), norm(now.f), norm(now.t));
    REQUIRE(growth(now.f, last.f) <= force * (1 + 1e-9));
    REQUIRE(growth(now.t, last.t) <= torque * (1 + 1e-9));
    REQUIRE(norm(now.f) <= kForce.limit);
    REQUIRE(norm(now.t) <= kTorque.limit);
    strongest = std::max(strongest, norm(now.f));
    hardest = std::max(hardest, norm(now.t));
    last = now;
  }
  CHECK(handle.state.fault == Fault::kNone);
  if (lever == 0) CHECK(strongest == Approx(kForce.limit));
  CHECK(hardest > 0.7 * kTorque.limit);
}

TEST_CASE("safety: a slap or a twist against a stiff wall is not slowed", "[servo]") {
  // the tool is off the handle: force and torque grow with the way and the turn of the hand, and
  // the full force comes at once
  const double stiffness = GENERATE(500.0, 3000.0), rotational = 4, lever = 0.05;
  const Vec3 normal = normalized(Vec3{1, 2, -2}),
             arm{0, lever / std::sqrt(2), lever / std::sqrt(2)};
  Handle handle;
  handle.limits = {
      .max_force = 40, .max_torque = 3, .soft_start = 0, .slew = 1, .torque_slew = 0.01};
  handle.input.stiffness = {stiffness, 0, rotational, lever};
  for (int k = -5; k < 8; ++k) {
    const double ticks = k + 0.4, inside = std::max(0.0, ticks);
    handle.input.device.X_BH.p = -1.5 * kTick * ticks * normal;
    handle.turn({15 * kTick, 0, 0});
    handle.input.F_B.f = stiffness * 1.5 * kTick * inside * normal;
    handle.input.F_B.t =
        cross(arm, handle.input.F_B.f) - Vec3{rotational * 15 * kTick * inside, 0, 0};
    const SafetyOutput out = handle.tick();
    CAPTURE(k);
    CHECK(out.F_B == handle.input.F_B);
    CHECK((out.flags & kServoSlewing) == 0);
  }
}

TEST_CASE("safety: a torque grows no faster than the force, and shrinks with it", "[servo]") {
  // without a slew of its own, as long to its limit as the force to its own: a fifth in each tick
  Handle handle;
  handle.limits.slew = 1000;
  handle.limits.torque_slew = 0;
  const SafetyOutput first = handle.ask({{}, {0, 0, 0.09}});
  CHECK_THAT(first.F_B.t, IsNear({0, 0, 0.04}, 1e-15));
  CHECK((first.flags & kServoSlewing) != 0);
  // the torque of a slowly growing force grows as slowly
  handle.ask({});
  const SafetyOutput both = handle.ask({{4, 0, 0}, {0, 0, 0.04}});
  CHECK_THAT(both.F_B.f, IsNear({1, 0, 0}, 1e-15));
  CHECK_THAT(both.F_B.t, IsNear({0, 0, 0.01}, 1e-15));
}

TEST_CASE("safety: what gives energy away is damped, but not where contacts fade", "[servo]") {
  const Half half = each_half();
  const bool fading = GENERATE(false, true);
  CAPTURE(half.name, fading);
  Handle handle;
  handle.input.device.flags = kGood;
  handle.limits.*half.damping = 0.1 * half.limit / half.fast();
  handle.ask(half.share(0.5));
  // pushed along at the velocity limit, 4 mJ and more in a tick
  half.move(handle, {2 * half.fast() * kTick, 0, 0});
  handle.input.fading = fading;
  const SafetyOutput out = handle.tick();
  CHECK(half.shares(out).x == Approx(fading ? 0.5 : 0.5 - 0.1 * 2));
  CHECK(((out.flags & kServoPassivity) != 0) == !fading);
}

TEST_CASE("safety: where contacts fade the passivity controller adds nothing", "[servo]") {
  // the force is gone and the hand falls or turns: an energy debt must not push against it
  const Half half = each_half();
  INFO(half.name);
  const auto pushed = [&](bool fading) {
    Handle handle;
    handle.input.device.flags = kGood;
    handle.state.passivity.energy = -20e-3;
    if (half.turns) handle.state.passivity.turning = -20e-3;
    double most = 0;
    for (int k = 0; k < 20; ++k) {
      handle.input.fading = fading && k >= 10;
      half.move(handle, {half.turns ? -4e-3 : -1e-4, 0, 0});
      const SafetyOutput out = handle.ask(half.share(k < 10 ? 0.4 : 0));
      if (k >= 10) most = std::max(most, norm(half.shares(out)));
      if (handle.input.fading) CHECK((out.flags & kServoPassivity) == 0);
    }
    return most;
  };
  CHECK(pushed(false) > 0.01);
  CHECK(pushed(true) == 0);
}

TEST_CASE("safety: the thermal budget brings the limit down to what the motors bear", "[servo]") {
  const Half half = each_half();
  const Half& other = half.turns ? kForce : kTorque;
  INFO(half.name);
  Handle handle;
  handle.limits.*half.continuous = 0.4 * half.limit;
  const Wrench asked = half.share(1.8) + other.share(0.8);
  double last = 1, squares = 0;
  const int ticks = 120'000;
  SafetyOutput out;
  for (int k = 0; k < ticks; ++k) {
    out = handle.ask(asked);
    const double now = half.shares(out).x;
    // never a step, never above the peak, and the other half keeps its own
    REQUIRE(now <= 1);
    REQUIRE(last - now <= 0.004);
    REQUIRE(out.F_B.*other.of == other.share(0.8).*other.of);
    if (k == 100) CHECK(now == Approx(1));
    last = now;
    if (k >= ticks / 2) squares += last * last;
  }
  CHECK((out.flags & kServoThermal) != 0);
  CHECK(std::sqrt(2 * squares / ticks) <= 0.4 * 1.0005);
  CHECK(last == Approx(0.4).epsilon(0.1));
  // a rest gives it back
  for (int k = 0; k < 60'000; ++k) handle.ask({});
  CHECK(half.shares(handle.ask(asked)).x == Approx(1));
}

TEST_CASE("safety: the edge of the workspace pushes and turns back softly", "[servo]") {
  const Half half = each_half();
  INFO(half.name);
  const Vec3 axis = normalized(Vec3{2, -1, 2});
  const double edge = half.turns ? 1 : 0.08;
  Handle handle;
  handle.limits.workspace_centre_B = {0.01, 0, 0};
  handle.limits.workspace_rest_B = from_rotation_vector({0, 0, 0.4});
  (half.turns ? handle.limits.workspace_turn : handle.limits.workspace_radius) = edge;
  const auto at = [&](double away) {
    handle.state.sample.known = false;
    handle.input.device.X_BH = {handle.limits.workspace_centre_B, handle.limits.workspace_rest_B};
    half.move(handle, away * axis);
    return handle.tick();
  };
  CHECK(at(0.999 * edge).F_B == Wrench{});
  CHECK_THAT(half.shares(at(edge + half.edge_width() / 2)), IsNear(-0.15 * axis, 1e-9));
  CHECK_THAT(half.shares(at(2 * edge)), IsNear(-0.3 * axis, 1e-9));
  CHECK((at(2 * edge).flags & kServoWorkspaceEdge) != 0);
}

TEST_CASE("safety: torque changes nothing of the force where there is none", "[servo]") {
  // the same hand and the same forces, once with torques and turns that are not rendered
  Random random(4);
  const auto any = [&](double most) {
    return random.in_box({-most, -most, -most}, {most, most, most});
  };
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

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety/safety.cpp.
#include "servo/safety/safety.h"

#include <limits>
#include <random>

#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kDt = 1e-3;
// the force may step in tests that are not about its growth
const SafetyLimits kLimits{.max_force = 5, .max_torque = 0.1, .soft_start = 0, .slew = 1e9};
const SafetyLimits kGrowing{.max_force = 5, .max_torque = 0.1, .soft_start = 0, .slew = 2000};
const double kNaN = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

SafetyState warm() {
  SafetyState state;
  state.gain = 1;
  return state;
}
SafetyInput asking(const Wrench& F_B) {
  SafetyInput input;
  input.F_B = F_B;
  return input;
}

}  // namespace

TEST_CASE("safety: a wrench within the limits passes unchanged", "[servo]") {
  SafetyState state = warm();
  const Wrench F{{1, -2, 3}, {0.01, 0.02, 0.03}};
  const SafetyOutput out = make_safe(kLimits, state, asking(F), kDt);
  CHECK(out.F_B == F);
  CHECK(out.flags == 0);
}

TEST_CASE("safety: saturation keeps the direction", "[servo]") {
  SafetyState state = warm();
  const Vec3 big{30, -40, 120};
  const SafetyOutput out = make_safe(kLimits, state, asking({big, {0, 0.3, 0.4}}), kDt);
  CHECK_THAT(out.F_B.f, IsNear(5.0 / 130 * big, 1e-12));
  CHECK_THAT(out.F_B.t, IsNear({0, 0.06, 0.08}, 1e-12));
  CHECK((out.flags & haptic::kServoSaturated) != 0);
}

TEST_CASE("safety: a saturated force is not above the limit by a single bit", "[servo]") {
  SafetyState state = warm();
  uint64_t seed = 3;
  auto uniform = [&] {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(seed >> 11) * 0x1p-52 - 1;
  };
  for (int i = 0; i < 100000; ++i) {
    const Vec3 f = 50 * Vec3{uniform(), uniform(), uniform()};
    REQUIRE(norm(make_safe(kLimits, state, asking({f, {}}), kDt).F_B.f) <= kLimits.max_force);
  }
}

TEST_CASE("safety: a large force is saturated, not a fault", "[servo]") {
  SafetyState state = warm();
  const double large = 999 * kLimits.max_force;
  const SafetyOutput out = make_safe(kLimits, state, asking({{large, 0, -large}, {}}), kDt);
  CHECK_THAT(out.F_B.f, IsNear({5 / std::sqrt(2.0), 0, -5 / std::sqrt(2.0)}, 1e-12));
}

TEST_CASE("safety: NaN and infinity latch a fault until it is cleared", "[servo]") {
  const Vec3 bad = GENERATE(Vec3{std::numeric_limits<double>::quiet_NaN(), 0, 0},
                            Vec3{0, std::numeric_limits<double>::infinity(), 0});
  SafetyState state = warm();
  SafetyOutput out = make_safe(kLimits, state, asking({bad, {}}), kDt);
  CHECK(out.F_B == Wrench{});
  CHECK((out.flags & haptic::kServoFault) != 0);

  // a valid wrench afterwards stays zero
  out = make_safe(kLimits, state, asking({{1, 0, 0}, {}}), kDt);
  CHECK(out.F_B == Wrench{});

  // cleared once: force again, from zero
  SafetyInput cleared = asking({{1, 0, 0}, {}});
  cleared.fault_clears = 1;
  SafetyLimits ramped = kLimits;
  ramped.soft_start = 0.1;
  out = make_safe(ramped, state, cleared, kDt);
  CHECK((out.flags & haptic::kServoFault) == 0);
  CHECK(norm(out.F_B.f) == 0);
  for (int i = 0; i < 101; ++i) out = make_safe(ramped, state, cleared, kDt);
  CHECK_THAT(out.F_B.f, IsNear({1, 0, 0}, 1e-12));
}

TEST_CASE("safety: a bad torque faults too", "[servo]") {
  SafetyState state = warm();
  const SafetyOutput nan = make_safe(kLimits, state, asking({{}, {0, 0, kNaN}}), kDt);
  CHECK((nan.flags & haptic::kServoFault) != 0);
  state = warm();
  const SafetyOutput inf = make_safe(kLimits, state, asking({{}, {-kInfinity, 0, 0}}), kDt);
  CHECK(inf.F_B == Wrench{});
}

TEST_CASE("safety: soft start rises linearly from zero and never steps", "[servo]") {
  SafetyState state;
  SafetyLimits limits = kLimits;
  limits.soft_start = 0.5;
  double before = 0;
  for (int k = 0; k <= 600; ++k) {
    const SafetyOutput out = make_safe(limits, state, asking({{0, 0, 4}, {}}), kDt);
    CHECK(out.F_B.f.z == Approx(4 * std::min(1.0, k * kDt / 0.5)).margin(1e-12));
    CHECK(out.F_B.f.z - before <= 4 * kDt / 0.5 + 1e-12);
    before = out.F_B.f.z;
  }
}

TEST_CASE("safety: closing the force zeroes it and opens through the soft start", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.soft_start = 0.5;
  SafetyInput input = asking({{0, 0, 4}, {}});
  input.force_closed = true;
  CHECK(make_safe(limits, state, input, kDt).F_B == Wrench{});
  input.force_closed = false;
  CHECK(make_safe(limits, state, input, kDt).F_B.f.z <= 4 * kDt / 0.5);
}

TEST_CASE("safety: a device without torque motors drops the torque and says so", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.max_torque = 0;
  const SafetyOutput out = make_safe(limits, state, asking({{1, 0, 0}, {0, 0, 0.02}}), kDt);
  CHECK(out.F_B.t == Vec3{});
  CHECK_THAT(out.F_B.f, IsNear({1, 0, 0}, 1e-15));
  CHECK((out.flags & haptic::kServoTorqueDropped) != 0);
  CHECK((out.flags & haptic::kServoSaturated) == 0);
}

TEST_CASE("safety: a force beyond all reason is a fault, not a wall", "[servo]") {
  const double huge = GENERATE(1001 * 5.0, 1e200, 1.7e308);
  SafetyState state = warm();
  const SafetyOutput out = make_safe(kLimits, state, asking({{0, huge, huge}, {}}), kDt);
  CHECK(out.F_B == Wrench{});
  CHECK(state.fault == haptic::Fault::kForceHuge);
}

TEST_CASE("safety: each fault names its reason, and the first one stays", "[servo]") {
  SafetyState state = warm();
  SafetyInput input = asking({{1, 0, 0}, {}});
  input.device_finite = false;
  make_safe(kLimits, state, input, kDt);
  CHECK(state.fault == haptic::Fault::kDeviceNotFinite);
  input.device_finite = true;
  input.contacts_finite = false;
  make_safe(kLimits, state, input, kDt);
  CHECK(state.fault == haptic::Fault::kDeviceNotFinite);
  state = warm();
  make_safe(kLimits, state, input, kDt);
  CHECK(state.fault == haptic::Fault::kContactsNotFinite);
  state = warm();
  make_safe(kLimits, state, asking({{kNaN, 0, 0}, {}}), kDt);
  CHECK(state.fault == haptic::Fault::kForceNotFinite);
}

TEST_CASE("safety: a fault is cleared only while the handle is calm", "[servo]") {
  SafetyState state = warm();
  make_safe(kLimits, state, asking({{kNaN, 0, 0}, {}}), kDt);
  SafetyInput input = asking({{1, 0, 0}, {}});
  input.fault_clears = 1;
  input.device.V_BH.v = {0.2, 0, 0};
  CHECK((make_safe(kLimits, state, input, kDt).flags & haptic::kServoFault) != 0);
  // the request waits: it need not be repeated
  input.device.V_BH.v = {0.05, 0, 0};
  CHECK((make_safe(kLimits, state, input, kDt).flags & haptic::kServoFault) == 0);
}

namespace {

/// A fresh sample at this position and time.
SafetyInput sample(const Vec3& p_B, double t_s) {
  SafetyInput input = asking({{1, 0, 0}, {}});
  input.device.X_BH.p = p_B;
  input.device.t_ns = 1'000'000'000 + static_cast<int64_t>(t_s * 1e9);
  input.now_ns = input.device.t_ns;
  input.device.flags = haptic::kDeviceFresh | haptic::kDeviceHomed | haptic::kDeviceOpenLoop;
  return input;
}

}  // namespace

TEST_CASE("safety: a device whose driver doubts it closes the force until it is cleared",
          "[servo]") {
  const auto [flag, fault] = GENERATE(
      table<uint32_t, haptic::Fault>({{haptic::kDeviceStale, haptic::Fault::kDeviceStale},
                                      {haptic::kDeviceNoisy, haptic::Fault::kDeviceNoisy}}));
  SafetyState state = warm();
  make_safe(kLimits, state, sample({}, 0), kDt);
  SafetyInput doubted = sample({}, 0.001);
  doubted.device.flags |= flag;
  CHECK(make_safe(kLimits, state, doubted, kDt).F_B == Wrench{});
  CHECK(state.fault == fault);
  // once healthy it waits for clear-fault, which has no effect before that
  CHECK(make_safe(kLimits, state, sample({}, 0.002), kDt).F_B == Wrench{});
  doubted.fault_clears = 1;
  make_safe(kLimits, state, doubted, kDt);
  CHECK(state.fault == fault);
  SafetyInput cleared = sample({}, 0.004);
  cleared.fault_clears = 2;
  CHECK(make_safe(kLimits, state, cleared, kDt).F_B.f.x == 1);
}

TEST_CASE("safety: a pose that jumps is a fault, over the time that was measured", "[servo]") {
  SafetyState state = warm();
  make_safe(kLimits, state, sample({}, 0), kDt);
  SECTION("one metre in a tick") {
    CHECK(make_safe(kLimits, state, sample({1, 0, 0}, 0.001), kDt).F_B == Wrench{});
    CHECK(state.fault == haptic::Fault::kPoseJump);
    // after clearing, the present position is not compared with earlier ones
    SafetyInput input = sample({1, 0, 0}, 0.002);
    input.fault_clears = 1;
    CHECK(make_safe(kLimits, state, input, kDt).F_B.f.x == 1);
  }
  SECTION("the same way after a pause in which it can have been gone") {
    CHECK(make_safe(kLimits, state, sample({1, 0, 0}, 0.3), kDt).F_B.f.x == 1);
  }
  SECTION("a sample that is held says nothing") {
    SafetyInput held = sample({1, 0, 0}, 0.001);
    held.device.flags = haptic::kDeviceHeld | haptic::kDeviceHomed | haptic::kDeviceOpenLoop;
    CHECK(make_safe(kLimits, state, held, kDt).F_B.f.x == 1);
  }
  SECTION("homing, and a device that comes back, move the pose rightly") {
    const uint32_t unknown = GENERATE(haptic::kDeviceFresh | haptic::kDeviceOpenLoop,
                                      haptic::kDeviceFresh | haptic::kDeviceHomed |
                                          haptic::kDeviceLost | haptic::kDeviceOpenLoop);
    SafetyInput moved = sample({0.5, 0, 0}, 0.001);
    moved.device.flags = unknown;
    make_safe(kLimits, state, moved, kDt);
    make_safe(kLimits, state, sample({1, 0, 0}, 0.002), kDt);
    CHECK(state.fault == haptic::Fault::kNone);
  }
  SECTION("a hand at the limit, with encoder steps and jitter, is no jump") {
    for (int k = 1; k < 1000; ++k) {
      const double jitter = k % 2 == 0 ? 2e-4 : -2e-4;
      make_safe(kLimits, state, sample({2.0 * k * 1e-3, 0, 0}, 1e-3 * k + jitter), kDt);
      REQUIRE(state.fault == haptic::Fault::kNone);
    }
  }
}

TEST_CASE("safety: too fast is zero until the hand is calm, then a soft start", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.soft_start = 0.1;
  SafetyInput input = asking({{1, 0, 0}, {}});
  const auto at = [&](double speed) {
    input.device.V_BH.v = {0, speed, 0};
    return make_safe(limits, state, input, kDt);
  };
  CHECK(at(1.99).F_B.f.x == 1);
  const SafetyOutput fast = at(2.01);
  CHECK(fast.F_B == Wrench{});
  CHECK((fast.flags & haptic::kServoTooFast) != 0);
  CHECK(at(0.5).F_B == Wrench{});
  CHECK(at(0.09).F_B.f.x == 0);
  CHECK(at(0.09).F_B.f.x == Approx(0.01));
}

TEST_CASE("safety: not armed is zero, arming starts softly", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.soft_start = 0.1;
  SafetyInput input = asking({{1, 0, 0}, {}});
  input.armed = false;
  const SafetyOutput off = make_safe(limits, state, input, kDt);
  CHECK(off.F_B == Wrench{});
  CHECK((off.flags & haptic::kServoDisarmed) != 0);
  input.armed = true;
  CHECK(make_safe(limits, state, input, kDt).F_B.f.x == 0);
  CHECK(make_safe(limits, state, input, kDt).F_B.f.x == Approx(0.01));
}

TEST_CASE("safety: after a release from outside the force rises from zero", "[servo]") {
  SafetyState state = warm();
  const Wrench F{{4, 0, 0}, {}};
  for (int k = 0; k < 2; ++k) make_safe(kGrowing, state, asking(F), kDt);
  CHECK(state.held_B == F);
  SafetyInput input = asking(F);
  input.released = true;
  const SafetyOutput first = make_safe(kGrowing, state, input, kDt);
  CHECK(first.F_B.f.x == Approx(kGrowing.slew * kDt));
  CHECK((first.flags & haptic::kServoSlewing) != 0);
  CHECK(make_safe(kGrowing, state, asking(F), kDt).F_B == F);
}

TEST_CASE("safety: the growth counts the time that has passed, not the ticks", "[servo]") {
  SafetyState state = warm();
  SafetyInput input = asking({{4.9, 0, 0}, {}});
  const auto at = [&](double ms) {
    input.now_ns = static_cast<int64_t>(1e6 * ms);
    const double force = make_safe(kGrowing, state, input, kDt).F_B.f.x;
    input.released = false;
    return force;
  };
  at(1);
  input.released = true;
  // a tick that is 10.6 ms late counts as one, the next, 0.4 ms later, as 0.4
  CHECK(at(12.6) == Approx(kGrowing.slew * kDt));
  CHECK(at(13) == Approx(1.4 * kGrowing.slew * kDt));
  CHECK(at(14) == Approx(2.4 * kGrowing.slew * kDt));
}

TEST_CASE("safety: whatever is asked for, no tick grows by more than slew and hand allow",
          "[servo]") {
  // any wrench, any motion of the hand below the velocity limit, closed loop or open
  std::mt19937 rng(15);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&](double most) { return most * Vec3{unit(rng), unit(rng), unit(rng)}; };
  const double stiffness = 800;
  SafetyState state = warm();
  SafetyInput input;
  input.stiffness.translational = stiffness;
  input.surface_velocity_B = {0.1, 0, 0};
  Vec3 last_p, last_F;
  double largest = 0;
  for (int k = 0; k < 20'000; ++k) {
    // a lie, a lasting lie, or the truth
    if (k % 3 != 0) input.F_B.f = any(20);
    input.device.X_BH.p += any(1e-3);
    input.device.V_BH.v = {};
    input.device.t_ns = input.now_ns = int64_t{1'000'000} * (k + 1);
    input.device.flags = haptic::kDeviceFresh | haptic::kDeviceHomed;
    if (k > 10'000) input.device.flags |= haptic::kDeviceOpenLoop;
    const Vec3 F = make_safe(kGrowing, state, input, kDt).F_B.f;
    const double moved = norm(input.device.X_BH.p - last_p);
    const double most = kGrowing.slew * kDt + (k > 0 ? stiffness * moved : 0);
    CAPTURE(k, norm(F), norm(last_F), moved);
    REQUIRE(norm(F) - norm(last_F) <= most * (1 + 1e-12));
    // nor in any direction: any part of the previous force may remain
    const double length2 = norm_squared(last_F);
    const double share = length2 > 0 ? std::clamp(dot(F, last_F) / length2, 0.0, 1.0) : 0;
    REQUIRE(norm(F - share * last_F) <= most * (1 + 1e-12));
    largest = std::max(largest, norm(F));
    last_p = input.device.X_BH.p;
    last_F = F;
  }
  CHECK(largest == Approx(kGrowing.max_force));
}

TEST_CASE("safety: a slap of 1.5 m/s on a stiff wall is not slowed", "[servo]") {
  // twice the slew limit in each tick, and the full force at once
  const double stiffness = GENERATE(500.0, 3000.0), speed = 1.5;
  const Vec3 normal = normalized(Vec3{1, 2, -2});
  SafetyLimits limits = kGrowing;
  limits.max_force = 40;
  SafetyState state = warm();
  SafetyInput input;
  input.stiffness.translational = stiffness;
  input.device.flags = haptic::kDeviceFresh | haptic::kDeviceHomed | haptic::kDeviceOpenLoop;
  for (int k = -5; k < 5; ++k) {
    const double depth = std::max(0.0, (k + 0.4) * speed * kDt);
    input.device.X_BH.p = -((k + 0.4) * speed * kDt) * normal;
    input.device.t_ns = input.now_ns = 1'000'000 * (k + 6);
    input.F_B.f = stiffness * depth * normal;
    const SafetyOutput out = make_safe(limits, state, input, kDt);
    CAPTURE(k, depth);
    CHECK(out.F_B == input.F_B);
    CHECK((out.flags & haptic::kServoSlewing) == 0);
  }
}

TEST_CASE("safety: what is held goes at once, what comes is slow", "[servo]") {
  SafetyState state = warm();
  const double step = kGrowing.slew * kDt;
  const auto ask = [&](const Vec3& f) { return make_safe(kGrowing, state, asking({f, {}}), kDt); };
  CHECK(ask({4, 0, 0}).F_B.f.x == step);
  CHECK(ask({4, 0, 0}).F_B.f.x == 4);
  CHECK(ask({0.5, 0, 0}).F_B.f.x == 0.5);
  // into a corner: the force of the existing wall is unchanged
  ask({2, 0, 0});
  CHECK_THAT(ask({2, 3, 0}).F_B.f, IsNear({2, step, 0}, 1e-12));
  // a wall on the other side
  ask({2, 0, 0});
  const SafetyOutput other = ask({-4.9, 0, 0});
  CHECK_THAT(other.F_B.f, IsNear({-step, 0, 0}, 1e-12));
  CHECK((other.flags & haptic::kServoSlewing) != 0);
}

TEST_CASE("safety: a torque grows no faster than the force, and shrinks with it", "[servo]") {
  SafetyLimits limits = kGrowing;
  limits.slew = 1000;
  SafetyState state = warm();
  // a fifth of the largest force and torque per tick
  const SafetyOutput first = make_safe(limits, state, asking({{}, {0, 0, 0.09}}), kDt);
  CHECK_THAT(first.F_B.t, IsNear({0, 0, 0.02}, 1e-15));
  CHECK((first.flags & haptic::kServoSlewing) != 0);
  // the torque of a slowly growing force grows as slowly
  state = warm();
  const SafetyOutput both = make_safe(limits, state, asking({{4, 0, 0}, {0, 0, 0.04}}), kDt);
  CHECK_THAT(both.F_B.f, IsNear({1, 0, 0}, 1e-15));
  CHECK_THAT(both.F_B.t, IsNear({0, 0, 0.01}, 1e-15));
  // changes due to the hand's own rotation are not slowed
  state = warm();
  SafetyInput turned = asking({});
  turned.stiffness.rotational = 1;
  turned.device.flags = haptic::kDeviceFresh | haptic::kDeviceHomed | haptic::kDeviceOpenLoop;
  make_safe(limits, state, turned, kDt);
  turned.F_B.t = {0, 0, 0.05};
  turned.device.t_ns = turned.now_ns = 1'000'000;
  turned.device.X_BH.q = haptic::from_rotation_vector({0, 0, -0.05});
  CHECK(make_safe(limits, state, turned, kDt).F_B == turned.F_B);
}

TEST_CASE("safety: where contacts fade the passivity controller adds nothing", "[servo]") {
  // the force is gone and the hand falls: an energy debt must not push against it
  const auto pushed = [](bool fading) {
    SafetyState state = warm();
    state.passivity.energy = -20e-3;
    double most = 0;
    for (int k = 0; k < 20; ++k) {
      SafetyInput input = asking({{k < 10 ? 2.0 : 0.0, 0, 0}, {}});
      input.fading = fading && k >= 10;
      input.now_ns = input.device.t_ns = k * 1'000'000;
      input.device.X_BH.p.x = -1e-4 * k;
      const SafetyOutput out = make_safe(kLimits, state, input, kDt);
      if (k >= 10) most = std::max(most, norm(out.F_B.f));
      if (input.fading) CHECK((out.flags & haptic::kServoPassivity) == 0);
    }
    return most;
  };
  CHECK(pushed(false) > 0.05);
  CHECK(pushed(true) == 0);
}

TEST_CASE("safety: the thermal budget brings the limit down to what the motors bear", "[servo]") {
  SafetyState state = warm();
  SafetyLimits limits = kLimits;
  limits.continuous_force = 2;
  double last = 5, squares = 0;
  const int ticks = 120'000;
  for (int k = 0; k < ticks; ++k) {
    const SafetyOutput out = make_safe(limits, state, asking({{9, 0, 0}, {}}), kDt);
    // never a step, never above the peak
    REQUIRE(out.F_B.f.x <= 5);
    REQUIRE(last - out.F_B.f.x <= 0.02);
    if (k == 100) CHECK(out.F_B.f.x == Approx(5));
    last = out.F_B.f.x;
    if (k >= ticks / 2) squares += last * last;
    if (k == ticks - 1) CHECK((out.flags & haptic::kServoThermal) != 0);
  }
  CHECK(std::sqrt(2 * squares / ticks) <= 2.001);
  CHECK(last == Approx(2).epsilon(0.1));
  // a rest gives it back
  for (int k = 0; k < 60'000; ++k) make_safe(limits, state, asking({}), kDt);
  CHECK(make_safe(limits, state, asking({{9, 0, 0}, {}}), kDt).F_B.f.x == Approx(5));
}

TEST_CASE("safety: the edge of the workspace pushes back softly", "[servo]") {
  SafetyLimits limits = kLimits;
  limits.workspace_radius = 0.08;
  limits.workspace_centre_B = {0.01, 0, 0};
  const auto at = [&](double x) {
    SafetyState state = warm();
    SafetyInput input = asking({});
    input.device.X_BH.p = {x, 0, 0};
    return make_safe(limits, state, input, kDt);
  };
  CHECK(at(0.0899).F_B == Wrench{});
  CHECK(at(0.0925).F_B.f.x == Approx(-0.75));
  CHECK(at(0.2).F_B.f.x == Approx(-1.5));
  CHECK((at(0.2).flags & haptic::kServoWorkspaceEdge) != 0);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The simulated arm alone: what its sensor says, in closed form.
#include "device-io/arm/simulated_arm.h"

#include <limits>

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

DeviceConfig arm_config() {
  DeviceConfig config;
  config.max_force = 20;
  config.max_torque = 1;
  config.hand.hand_mass = config.hand.hand_damping = config.hand.hand_stiffness = 0;
  config.hand.hand_inertia = config.hand.hand_rotational_damping = 0;
  config.hand.hand_rotational_stiffness = 0;
  return config;
}

Intent at_origin(double) {
  return {};
}

/// The sample of a tick that wakes late.
DeviceState read_at(SimulatedArm& arm, int64_t tick, int64_t late_ns = 0) {
  DeviceState state{};
  arm.read({tick * kMs, tick * kMs + late_ns}, state);
  return state;
}

}  // namespace

TEST_CASE("simulated arm: it says that it measures, and is simulated", "[device]") {
  SimulatedArm arm(arm_config(), at_origin);
  CHECK(arm.caps().causality == Causality::kAdmittance);
  CHECK(arm.caps().simulated);
  CHECK(arm.caps().max_torque == 1);
  const DeviceState first = read_at(arm, 1);
  CHECK((first.flags & kDeviceAdmittance) != 0);
  CHECK((first.flags & kDeviceFresh) != 0);
  CHECK(first.F_hand_B == Wrench{});
}

TEST_CASE("simulated arm: a command is reached one tick later, and the delay after", "[device]") {
  DeviceConfig config = arm_config();
  const int delay = GENERATE(0, 1, 3);
  config.admittance.arm_delay = 1e-3 * delay;
  SimulatedArm arm(config, at_origin);
  read_at(arm, 1);
  read_at(arm, 2);
  arm.move({{1e-3, 0, 0}, {}});
  for (int k = 3; k < 8; ++k) {
    const double x = read_at(arm, k).X_BH.p.x;
    CHECK(x == Approx(k >= 3 + delay ? 1e-3 : 0).margin(1e-12));
  }
}

TEST_CASE("simulated arm: spring, damper and mass of the hand, of moving and of turning",
          "[device]") {
  DeviceConfig config = arm_config();
  config.hand.hand_stiffness = 100;
  config.hand.hand_damping = 4;
  config.hand.hand_mass = 0.5;
  config.hand.hand_rotational_stiffness = 2;
  config.hand.hand_rotational_damping = 0.01;
  config.hand.hand_inertia = 1e-3;
  SimulatedArm arm(config, at_origin);
  read_at(arm, 1);
  read_at(arm, 2);
  // one millimetre and ten milliradians in a tick: 1 m/s, 10 rad/s, from rest
  arm.move({{0, 1e-3, 0}, from_rotation_vector({0.01, 0, 0})});
  DeviceState s = read_at(arm, 3);
  CHECK_THAT(s.V_BH.v, IsNear({0, 1, 0}, 1e-9));
  // −k x/2 − b v − m v/T, with x the end of the way
  CHECK_THAT(s.F_hand_B.f, IsNear({0, -0.05 - 4 - 500, 0}, 1e-6));
  CHECK_THAT(s.F_hand_B.t, IsNear({-0.01 - 0.1 - 10, 0, 0}, 1e-6));
  // it stops at the beginning of the next tick
  s = read_at(arm, 4);
  CHECK_THAT(s.F_hand_B.f, IsNear({0, -0.1 + 500, 0}, 1e-6));
  s = read_at(arm, 5);
  CHECK_THAT(s.F_hand_B.f, IsNear({0, -0.1, 0}, 1e-9));
  CHECK_THAT(s.F_hand_B.t, IsNear({-0.02, 0, 0}, 1e-9));
}

TEST_CASE("simulated arm: its work is the energy of the hand's spring and mass", "[device]") {
  DeviceConfig config = arm_config();
  config.hand.hand_stiffness = 100;
  config.hand.hand_mass = 0.5;
  SimulatedArm arm(config, at_origin);
  read_at(arm, 1);
  for (int k = 2; k < 12; ++k) {
    read_at(arm, k);
    arm.move({{1e-3 * (k - 1), 0, 0}, {}});
  }
  read_at(arm, 12);
  // at 1 m/s, 10 mm away
  CHECK(arm.hand_work().moving == Approx(-0.5 * 100 * 1e-4 - 0.5 * 0.5));
  read_at(arm, 13);
  CHECK(arm.hand_work().moving == Approx(-0.5 * 100 * 1e-4));
  CHECK(arm.hand_work().turning == 0);
}

TEST_CASE("simulated arm: commands that are late by less than its delay are played evenly",
          "[device]") {
  DeviceConfig config = arm_config();
  config.admittance.arm_delay = 1e-3;
  SimulatedArm arm(config, at_origin);
  read_at(arm, 1);
  // it is commanded on at 0.2 m/s, in ticks that wake at 0 to 0.9 ms after their deadline
  for (int k = 2; k < 60; ++k) {
    const int64_t late_ns = (k * 7 % 10) * 100'000;
    const DeviceState s = read_at(arm, k, late_ns);
    const double then = 1e-9 * static_cast<double>(s.t_ns) - 1e-3;
    if (k > 5) REQUIRE(s.X_BH.p.x == Approx(0.2 * (then - 2e-3)).margin(1e-9));
    arm.move({{0.2e-3 * (k - 1), 0, 0}, {}});
  }
}

TEST_CASE("simulated arm: after a late command it has rested, and goes no faster for it",
          "[device]") {
  SimulatedArm arm(arm_config(), at_origin);
  read_at(arm, 1);
  read_at(arm, 2);
  arm.move({{1e-3, 0, 0}, {}});
  CHECK(read_at(arm, 3, 900'000).X_BH.p.x == Approx(1e-3));
  arm.move({{2e-3, 0, 0}, {}});
  // a tenth of a millisecond later there is no new mean
  const DeviceState soon = read_at(arm, 4);
  CHECK((soon.flags & kDeviceFresh) == 0);
  CHECK((soon.flags & kDeviceHeld) != 0);
  arm.move({{2e-3, 0, 0}, {}});
  CHECK(norm(read_at(arm, 5).V_BH.v) < 1.01);
}

TEST_CASE("simulated arm: it does not follow a pose that is none, and stops where it is",
          "[device]") {
  DeviceConfig config = arm_config();
  config.admittance.arm_delay = 2e-3;
  SimulatedArm arm(config, at_origin);
  read_at(arm, 1);
  read_at(arm, 2);
  arm.move({{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}});
  CHECK(read_at(arm, 3).X_BH == Pose{});
  arm.move({{1e-3, 0, 0}, {}});
  read_at(arm, 4);
  arm.stop();
  for (int k = 5; k < 12; ++k) CHECK(read_at(arm, k).X_BH == Pose{});
}

TEST_CASE("simulated arm: without torque none is measured", "[device]") {
  DeviceConfig config = arm_config();
  config.max_torque = 0;
  config.hand.hand_rotational_stiffness = 2;
  SimulatedArm arm(config, at_origin);
  read_at(arm, 1);
  arm.move({{}, from_rotation_vector({0.1, 0, 0})});
  CHECK(read_at(arm, 2).F_hand_B == Wrench{});
  CHECK(read_at(arm, 3).F_hand_B == Wrench{});
}

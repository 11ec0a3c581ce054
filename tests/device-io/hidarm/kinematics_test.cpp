// SPDX-License-Identifier: GPL-3.0-or-later
// The geometry of a config, by the formulas of CWoodenDevice.cpp (WoodenHaptics/woody-experimental,
// getPosition and setForceAndTorqueAndGripperForce, USB, neither gravity nor ALUHAPTICS), written
// out here with its own signs.
#include <catch2/catch.hpp>
#include <cmath>

#include "device-io/hidarm/hid_arm.h"
#include "proto/math/units.h"
#include "tests/support/driver/bench.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::largest_of;

namespace {

/// θ_A, θ_B, θ_C of the reference for counts of the board.
Vec3 reference_angles(const HidArmConfig& c, const MotorCounts& n) {
  const double a = 2 * kPi * -n[0] / c.counts_per_turn / (c.bodies.x / c.capstans.x);
  const double b = 2 * kPi * n[1] / c.counts_per_turn / (-c.bodies.y / c.capstans.y);
  const double g = 2 * kPi * n[2] / c.counts_per_turn / (c.bodies.z / c.capstans.z);
  return {a, b, kPi / 2 - g};
}

Vec3 reference_place(const HidArmConfig& c, const Vec3& t) {
  const double out = c.links.y * std::sin(t.y) + c.links.z * std::sin(t.z);
  return {std::cos(t.x) * out - 0.22, std::sin(t.x) * out,
          c.links.y * std::cos(t.y) - c.links.z * std::cos(t.z)};
}

/// Milliamperes of the reference.
Vec3 reference_currents(const HidArmConfig& c, const Vec3& t, const Vec3& F) {
  const double b = c.links.y, g = c.links.z;
  const double out = b * std::sin(t.y) + g * std::sin(t.z);
  const Vec3 torques{-std::sin(t.x) * out * F.x + std::cos(t.x) * out * F.y,
                     b * std::cos(t.x) * std::cos(t.y) * F.x +
                         b * std::sin(t.x) * std::cos(t.y) * F.y - b * std::sin(t.y) * F.z,
                     g * std::cos(t.x) * std::cos(t.z) * F.x +
                         g * std::sin(t.x) * std::cos(t.z) * F.y + g * std::sin(t.z) * F.z};
  return 1000 / c.torque_constant *
         Vec3{torques.x * c.capstans.x / c.bodies.x, -torques.y * c.capstans.y / c.bodies.y,
              -torques.z * c.capstans.z / c.bodies.z};
}

/// That of 2016, and one of other lengths, capstans and encoders.
HidArmConfig geometry(int which) {
  HidArmConfig arm;
  if (which == 0) return arm;
  arm.links = {0.111, 0.180, 0.211};
  arm.capstans = {0.0138, 0.0098, 0.0098};
  arm.bodies = {0.116, 0.076, 0.076};
  arm.counts_per_turn = 4096;
  arm.torque_constant = 0.03;
  return arm;
}

}  // namespace

TEST_CASE("hid arm: place and currents are those of the CHAI3D module", "[device-io]") {
  const HidArmConfig config = geometry(GENERATE(0, 1));
  const int32_t a = GENERATE(-1500, 0, 1700), b = GENERATE(-3000, -1000), c = GENERATE(0, 1500);
  const Arm arm = hid_arm(config);
  const JointAngles q = arm.angles({a, b, c});
  const Vec3 t = reference_angles(config, {a, b, c});
  // the home of a config is rounded to a count: 0.13 mrad
  CHECK_THAT(arm.pose(q).p, IsNear(reference_place(config, t), 6e-5));
  const Vec3 F_B{0.4, -0.3, 0.5};
  MotorEfforts motors;
  REQUIRE(arm.efforts(q, {}, {F_B, {}}, motors));
  const Vec3 wanted = reference_currents(config, t, F_B);
  CHECK_THAT(1000 * Vec3(motors[0], motors[1], motors[2]), IsNear(wanted, 1.5));
}

TEST_CASE("hid arm: currents beyond the limit are scaled by one factor", "[device-io]") {
  DeviceConfig config;
  config.hid_arm.max_current = 0.5;
  const auto mailbox = std::make_shared<MotorMailbox>();
  ThreeMotorDevice device(hid_arm(config.hid_arm), {}, config, mailbox);
  DeviceState state;
  mailbox->put({{300, -2500, 1200}, 0, 0, kMs, kMs});
  REQUIRE(device.read({kMs, kMs}, state));
  const auto told = [&](const Vec3& F_B) {
    device.write({F_B, {}});
    const auto motors = mailbox->command_at(kMs)->motors;
    device.read({kMs, kMs}, state);
    return Vec3(motors[0], motors[1], motors[2]);
  };
  told({0.02, -0.03, 0.05});
  CHECK((state.flags & kDeviceSaturated) == 0);
  const Vec3 large = told({2, -3, 3});
  CHECK((state.flags & kDeviceSaturated) != 0);
  CHECK(largest_of(std::array{large.x, large.y, large.z}) == 500);
  const Vec3 wanted = reference_currents(
      config.hid_arm, reference_angles(config.hid_arm, {300, -2500, 1200}), {2, -3, 3});
  CHECK_THAT(normalized(large), IsNear(normalized(wanted), 3e-3));
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The geometry of a config, by the formulas of CWoodenDevice.cpp (WoodenHaptics/woody-experimental,
// getPosition and setForceAndTorqueAndGripperForce, USB, neither gravity nor ALUHAPTICS), written
// out here with its own signs.
#include <catch2/catch.hpp>
#include <cmath>

#include "device-io/hidarm/hid_arm.h"
#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;

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
  ThreeMotorArm arm = hid_arm(config);
  Vec3 p_B;
  REQUIRE(arm.place({a, b, c}, false, p_B));
  const Vec3 t = reference_angles(config, {a, b, c});
  // the home of a config is rounded to a count: 0.13 mrad
  CHECK_THAT(p_B, IsNear(reference_place(config, t), 6e-5));
  const Vec3 F_B{0.4, -0.3, 0.5};
  std::array<int16_t, 3> motors{};
  bool clipped = true;
  REQUIRE(arm.drive(F_B, motors, clipped));
  CHECK_FALSE(clipped);
  const Vec3 wanted = reference_currents(config, t, F_B);
  CHECK_THAT(Vec3(motors[0], motors[1], motors[2]), IsNear(wanted, 1.5));
}

TEST_CASE("hid arm: currents beyond the limit are scaled by one factor", "[device-io]") {
  HidArmConfig config;
  config.max_current = 0.5;
  ThreeMotorArm arm = hid_arm(config);
  Vec3 p_B;
  arm.place({300, -2500, 1200}, false, p_B);
  std::array<int16_t, 3> small{}, large{};
  bool clipped = false;
  arm.drive({0.02, -0.03, 0.05}, small, clipped);
  CHECK_FALSE(clipped);
  arm.drive({2, -3, 5}, large, clipped);
  CHECK(clipped);
  const int most = std::max({std::abs(large[0]), std::abs(large[1]), std::abs(large[2])});
  CHECK(most == 500);
  const Vec3 wanted =
      reference_currents(config, reference_angles(config, {300, -2500, 1200}), {2, -3, 5});
  CHECK_THAT(normalized(Vec3(large[0], large[1], large[2])), IsNear(normalized(wanted), 3e-3));
}

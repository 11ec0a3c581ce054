// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

constexpr double kAlgebra = 1e-12;
const WoodenHapticsGeometry kArm;

Vec3 random_vector() {
  return {GENERATE(take(5, random(-1.0, 1.0))), GENERATE(take(5, random(-1.0, 1.0))),
          GENERATE(take(5, random(-1.0, 1.0)))};
}

/// A position within the workspace: a box of 16 cm around the origin.
Vec3 random_place() {
  return 0.08 * random_vector();
}

}  // namespace

TEST_CASE("woodenhaptics: at home the upper arm stands and the forearm lies", "[device-io]") {
  // x = Lc − 0.22, z = La + Lb − 0.08, by hand from the lengths of the device
  CHECK_THAT(joint_angles(kArm, {0, 0, 0}), IsNear({0, 0, std::numbers::pi / 2}, kAlgebra));
  CHECK_THAT(tip_position(kArm, joint_angles(kArm, {0, 0, 0})),
             IsNear({0.025, 0, 0.205}, kAlgebra));
}

TEST_CASE("woodenhaptics: encoder counts turn the bodies as the reference says", "[device-io]") {
  // a quarter turn of body A: 2000 · 16 / 4 counts. The tip goes round to +y
  CHECK_THAT(tip_position(kArm, joint_angles(kArm, {8000, 0, 0})),
             IsNear({-0.220, 0.245, 0.205}, kAlgebra));
  // motor B turns against its body: −3000 counts of 24000 lean the upper arm 45° forward
  const double s = std::sqrt(0.5);
  CHECK_THAT(tip_position(kArm, joint_angles(kArm, {0, -3000, 0})),
             IsNear({0.205 * s + 0.025, 0, 0.205 * s}, kAlgebra));
  // and so does C: 3000 counts let the forearm hang 45° down
  CHECK_THAT(tip_position(kArm, joint_angles(kArm, {0, 0, 3000})),
             IsNear({0.245 * s - 0.220, 0, 0.205 - 0.245 * s}, kAlgebra));
}

TEST_CASE("woodenhaptics: one count moves the tip by what the reference gives", "[device-io]") {
  // 2π · 0.245 / 2000 / 12 = 64 µm
  const Vec3 before = tip_position(kArm, joint_angles(kArm, {0, 0, 0}));
  const Vec3 after = tip_position(kArm, joint_angles(kArm, {0, 0, 1}));
  CHECK(norm(after - before) == Approx(64.14e-6).epsilon(1e-3));
}

TEST_CASE("woodenhaptics: the Jacobian is the derivative of the tip", "[device-io]") {
  const Vec3 p_B = random_place();
  CAPTURE(p_B);
  Vec3 q;
  REQUIRE(solve_joint_angles(kArm, p_B, q));
  const Mat3 J = tip_jacobian(kArm, q);
  constexpr double kStep = 1e-5;  // error of a central difference: h²/6 · 0.25 m = 4e-12
  for (int i = 0; i < 3; ++i) {
    Vec3 forward = q, back = q;
    forward[i] += kStep;
    back[i] -= kStep;
    const Vec3 difference = (tip_position(kArm, forward) - tip_position(kArm, back)) / (2 * kStep);
    CHECK_THAT(J.column(i), IsNear(difference, 1e-10));
  }
}

TEST_CASE("woodenhaptics: motors do the work that the tip does", "[device-io]") {
  const Vec3 p_B = random_place();
  const Vec3 F_B = 5 * Vec3{GENERATE(take(2, random(-1.0, 1.0))), 0.3, -0.7};
  CAPTURE(p_B, F_B);
  Vec3 q;
  REQUIRE(solve_joint_angles(kArm, p_B, q));
  const Vec3 amperes = motor_currents(kArm, q, F_B);
  // a motor turns one revolution in 2000 counts, whatever body it drives, and its torque is
  // 0.0259 N·m an ampere: independent of capstans and signs
  constexpr double kRadiansPerCount = 2 * std::numbers::pi / 2000;
  constexpr int32_t kCounts = 1;
  const MotorCounts here = motor_counts(kArm, q);
  const Vec3 exact = joint_angles(kArm, here);
  for (size_t i = 0; i < 3; ++i) {
    MotorCounts forward = here, back = here;
    forward[i] += kCounts;
    back[i] -= kCounts;
    const Vec3 way_B = tip_position(kArm, joint_angles(kArm, forward)) -
                       tip_position(kArm, joint_angles(kArm, back));
    const double by_tip = dot(F_B, way_B);
    const double by_motor = 0.0259 * motor_currents(kArm, exact, F_B)[static_cast<int>(i)] *
                            kRadiansPerCount * 2 * kCounts;
    CHECK(std::fabs(by_tip - by_motor) <= tol(1e-10));
  }
  CHECK_THAT(tip_force(kArm, q, amperes), IsNear(F_B, 1e-12));
}

TEST_CASE("woodenhaptics: the angles found for a place bring the tip there", "[device-io]") {
  const Vec3 p_B = random_place();
  CAPTURE(p_B);
  Vec3 q;
  REQUIRE(solve_joint_angles(kArm, p_B, q));
  CHECK_THAT(tip_position(kArm, q), IsNear(p_B, kAlgebra));
  CHECK(q.y + q.z > 0);
  CHECK(q.y + q.z < std::numbers::pi);
  // an encoder reads the count below, along its own motor
  const Vec3 below = joint_angles(kArm, motor_counts(kArm, q));
  for (int i = 0; i < 3; ++i) {
    const double step = 2 * std::numbers::pi / (2000 * kArm.ratio[static_cast<size_t>(i)]);
    const double over = (q[i] - below[i]) * kArm.direction[static_cast<size_t>(i)];
    CHECK(over >= -tol(kAlgebra));
    CHECK(over < step + tol(kAlgebra));
  }
}

TEST_CASE("woodenhaptics: a place out of reach is refused, a stretched arm pushes nothing",
          "[device-io]") {
  Vec3 q;
  CHECK_FALSE(solve_joint_angles(kArm, {0.5, 0, 0}, q));
  CHECK_FALSE(solve_joint_angles(kArm, Vec3{0, 0, 0.08} - kArm.origin, q));
  CHECK(tip_force(kArm, {0, std::numbers::pi / 2, std::numbers::pi / 2}, {1, 1, 1}) == Vec3{});
}

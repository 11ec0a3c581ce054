// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/sixmotors/kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "device-io/emulator/fault_order.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

constexpr double kAlgebra = 1e-12;
const SixMotorsGeometry kDevice;

/// Places and turns of the handle within the workspace: 16 cm and one radian.
struct Draw {
  std::minstd_rand random{1};
  Vec3 vector(double most) {
    std::uniform_real_distribution<double> one(-1, 1);
    const Vec3 a{one(random), one(random), one(random)};
    return most / std::sqrt(3.0) * a;
  }
  Pose pose() { return {vector(0.14), from_rotation_vector(vector(1))}; }
};

/// How far two orientations are apart [rad].
double angle_between(const Quat& a, const Quat& b) {
  return norm(to_rotation_vector(a * conjugate(b)));
}

Pose pose_of(const MotorCounts& counts) {
  return handle_pose(kDevice, joint_angles(kDevice, counts));
}

/// What a turned handle does to its three axes, checked vector by vector.
void check_axes(const MotorCounts& counts, const Vec3& x_B, const Vec3& z_B) {
  const Quat q = pose_of(counts).q;
  CAPTURE(counts[0], counts[2], counts[3], counts[4], counts[5]);
  CHECK_THAT(rotate(q, {1, 0, 0}), IsNear(x_B, kAlgebra));
  CHECK_THAT(rotate(q, {0, 0, 1}), IsNear(z_B, kAlgebra));
}

}  // namespace

TEST_CASE("six motors: at home the handle is upright where a WoodenHaptics has its tip",
          "[device-io]") {
  // 245 mm − 220 mm, 80 mm + 205 mm − 80 mm, by hand
  CHECK_THAT(pose_of({}).p, IsNear({0.025, 0, 0.205}, kAlgebra));
  check_axes({}, {1, 0, 0}, {0, 0, 1});
}

TEST_CASE("six motors: each motor turns the handle about its axis, by its sign", "[device-io]") {
  // a quarter turn of a joint of the wrist is 4096 · 8 / 4 counts
  const int32_t quarter = 8192;
  check_axes({0, 0, 0, quarter, 0, 0}, {0, 0, -1}, {1, 0, 0});   // pitch, about y
  check_axes({0, 0, 0, 0, -quarter, 0}, {1, 0, 0}, {0, -1, 0});  // roll, about x, motor reversed
  check_axes({0, 0, 0, 0, 0, quarter}, {0, 1, 0}, {0, 0, 1});    // yaw, about z
  // the arm carries the wrist: a quarter turn of the foot is 2000 · 16 / 4 counts, and 6000 counts
  // let the forearm hang from level; the upper arm is a parallel linkage
  check_axes({8000, 0, 0, 0, 0, 0}, {0, 1, 0}, {0, 0, 1});
  check_axes({0, 0, 6000, 0, 0, 0}, {0, 0, -1}, {1, 0, 0});
  check_axes({0, -3000, 0, 0, 0, 0}, {1, 0, 0}, {0, 0, 1});
  // roll turns about the axis that pitch carries, yaw about the handle's own
  check_axes({0, 0, 0, quarter, -quarter, 0}, {0, 0, -1}, {0, -1, 0});
  check_axes({0, 0, 0, 0, -quarter, quarter}, {0, 0, 1}, {0, -1, 0});
  // all axes of the wrist meet in the handle's origin
  CHECK(pose_of({500, -700, 900, 3000, 2000, -1000}).p == pose_of({500, -700, 900, 0, 0, 0}).p);
}

TEST_CASE("six motors: the Jacobian is the derivative of the pose", "[device-io]") {
  constexpr double kStep = 1e-5;  // error of a central difference: h²/6 = 2e-11
  Draw draw;
  for (int n = 0; n < 200; ++n) {
    JointAngles q;
    REQUIRE(solve_joint_angles(kDevice, draw.pose(), q));
    const auto J = handle_jacobian(kDevice, q);
    for (size_t i = 0; i < 6; ++i) {
      JointAngles forward = q, back = q;
      forward[i] += kStep;
      back[i] -= kStep;
      const Pose a = handle_pose(kDevice, back), b = handle_pose(kDevice, forward);
      CAPTURE(n, i);
      REQUIRE_THAT(J[i].v, IsNear((b.p - a.p) / (2 * kStep), 1e-9));
      REQUIRE_THAT(J[i].w, IsNear(to_rotation_vector(b.q * conjugate(a.q)) / (2 * kStep), 1e-9));
    }
  }
}

TEST_CASE("six motors: the motors do the work that the handle does", "[device-io]") {
  // an ampere gives 0.0259 N·m in the arm and 0.0138 N·m in the wrist, a turn of a motor is 2000
  // and 4096 counts: independent of capstans and signs
  const double arm = 0.0259 * 2 * std::numbers::pi / 2000;
  const double wrist = 0.0138 * 2 * std::numbers::pi / 4096;
  Draw draw;
  for (int n = 0; n < 50; ++n) {
    JointAngles q;
    REQUIRE(solve_joint_angles(kDevice, draw.pose(), q));
    const MotorCounts here = motor_counts(kDevice, q);
    const Wrench F_B{draw.vector(5), draw.vector(0.3)};
    const MotorAmperes amperes = motor_currents(kDevice, joint_angles(kDevice, here), F_B);
    for (size_t i = 0; i < 6; ++i) {
      MotorCounts forward = here, back = here;
      ++forward[i];
      --back[i];
      const Pose a = pose_of(back), b = pose_of(forward);
      const double by_handle =
          dot(F_B.f, b.p - a.p) + dot(F_B.t, to_rotation_vector(b.q * conjugate(a.q)));
      CAPTURE(n, i);
      REQUIRE(std::fabs(by_handle - 2 * (i < 3 ? arm : wrist) * amperes[i]) <= tol(1e-9));
    }
  }
}

TEST_CASE("six motors: currents and wrenches are each other's inverse", "[device-io]") {
  Draw draw;
  for (int n = 0; n < 200; ++n) {
    JointAngles q;
    REQUIRE(solve_joint_angles(kDevice, draw.pose(), q));
    const Wrench F_B{draw.vector(5), draw.vector(0.3)};
    const Wrench back = handle_wrench(kDevice, q, motor_currents(kDevice, q, F_B));
    REQUIRE_THAT(back.f, IsNear(F_B.f, 1e-11));
    REQUIRE_THAT(back.t, IsNear(F_B.t, 1e-12));
  }
}

TEST_CASE("six motors: what the arm's motors take of a torque is no force", "[device-io]") {
  // a torque about z turns the foot as well, one about the elbow's axis the forearm
  JointAngles q;
  REQUIRE(solve_joint_angles(kDevice, {{0.02, 0.03, -0.01}, {}}, q));
  const MotorAmperes amperes = motor_currents(kDevice, q, {{}, {0, 0.2, 0.1}});
  CHECK(std::fabs(amperes[0]) > 0.1);
  CHECK(amperes[1] == 0);
  CHECK(std::fabs(amperes[2]) > 0.1);
  CHECK(norm(handle_wrench(kDevice, q, amperes).f) <= tol(1e-12));
}

TEST_CASE("six motors: the angles found for a pose bring the handle there", "[device-io]") {
  Draw draw;
  for (int n = 0; n < 200; ++n) {
    const Pose X_BH = draw.pose();
    JointAngles q;
    REQUIRE(solve_joint_angles(kDevice, X_BH, q));
    const Pose back = handle_pose(kDevice, q);
    REQUIRE_THAT(back.p, IsNear(X_BH.p, kAlgebra));
    REQUIRE(angle_between(back.q, X_BH.q) <= tol(1e-10));
    // whole counts: each joint at most one below its motor, so the handle within their sum
    const Pose seen = pose_of(motor_counts(kDevice, q));
    REQUIRE(norm(seen.p - X_BH.p) < 250e-6);
    const double steps = 2 * std::numbers::pi * (3.0 / 32768 + 1.0 / 32000 + 1.0 / 24000);
    REQUIRE(angle_between(seen.q, X_BH.q) < steps);
  }
}

TEST_CASE("six motors: stops, reach and singular poses", "[device-io]") {
  JointAngles q{1, 2, 3, 4, 5, 6};
  CHECK_FALSE(solve_joint_angles(kDevice, {{0.5, 0, 0}, {}}, q));
  CHECK_FALSE(solve_joint_angles(kDevice, {{}, from_rotation_vector({1.45, 0, 0})}, q));
  CHECK(q == JointAngles{1, 2, 3, 4, 5, 6});
  // any other axis turns farther
  CHECK(solve_joint_angles(kDevice, {{}, from_rotation_vector({0, 2, 0})}, q));
  CHECK(solve_joint_angles(kDevice, {{}, from_rotation_vector({0, 0, 2})}, q));
  // pitch and yaw about the same axis
  q[4] = std::numbers::pi / 2;
  CHECK(handle_wrench(kDevice, q, {1, 1, 1, 1, 1, 1}) == Wrench{});
  // the whole workspace is far from that: the tilt of the handle alone makes it
  Draw draw;
  for (int n = 0; n < 1000; ++n) {
    const Pose X_BH{draw.vector(0.19), from_rotation_vector(draw.vector(1.047))};
    REQUIRE(solve_joint_angles(kDevice, X_BH, q));
    REQUIRE(std::fabs(q[4]) <= tol(1.1));
  }
}

TEST_CASE("six motors: the planted jump is a turn of one radian", "[device-io]") {
  JointAngles q;
  REQUIRE(solve_joint_angles(kDevice, {{}, from_rotation_vector({0.2, -0.3, 0.1})}, q));
  const MotorCounts here = motor_counts(kDevice, q);
  MotorCounts jumped = here;
  for (size_t i = 0; i < 6; ++i) jumped[i] += kTurnJumpCounts[i];
  CHECK(pose_of(jumped).p == pose_of(here).p);
  CHECK(angle_between(pose_of(jumped).q, pose_of(here).q) == Approx(1).epsilon(1e-4));
}

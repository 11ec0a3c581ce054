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
using haptic::test::kAlgebra;
using haptic::test::tol;

namespace {

const Arm& kDevice = six_motors_arm();

/// How far two orientations are apart [rad].
double angle_between(const Quat& a, const Quat& b) {
  return norm(to_rotation_vector(a * conjugate(b)));
}

Pose pose_of(const MotorCounts& counts) {
  return kDevice.pose(kDevice.angles(counts));
}

/// Checks vector by vector that a turned handle turns its three axes.
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

TEST_CASE("six motors: what the arm's motors take of a torque is no force", "[device-io]") {
  // a torque about z turns the foot as well, one about the elbow's axis the forearm
  JointAngles q;
  REQUIRE(kDevice.solve({{0.02, 0.03, -0.01}, {}}, q));
  MotorEfforts amperes;
  REQUIRE(kDevice.efforts(q, {}, {{}, {0, 0.2, 0.1}}, amperes));
  CHECK(std::fabs(amperes[0]) > 0.1);
  CHECK(amperes[1] == 0);
  CHECK(std::fabs(amperes[2]) > 0.1);
  CHECK(norm(kDevice.wrench(q, amperes).f) <= tol(1e-12));
}

TEST_CASE("six motors: stops, reach and singular poses", "[device-io]") {
  JointAngles q{1, 2, 3, 4, 5, 6};
  CHECK_FALSE(kDevice.solve({{}, from_rotation_vector({1.45, 0, 0})}, q));
  CHECK(q == JointAngles{1, 2, 3, 4, 5, 6});
  // any other axis turns farther
  CHECK(kDevice.solve({{}, from_rotation_vector({0, 2, 0})}, q));
  CHECK(kDevice.solve({{}, from_rotation_vector({0, 0, 2})}, q));
  // pitch and yaw about the same axis
  q[4] = std::numbers::pi / 2;
  CHECK(kDevice.wrench(q, {1, 1, 1, 1, 1, 1}) == Wrench{});
  // the whole workspace is far from that: the tilt of the handle alone makes it
  std::minstd_rand random{1};
  std::uniform_real_distribution<double> one(-0.577, 0.577);
  const auto draw = [&] { return Vec3{one(random), one(random), one(random)}; };
  for (int n = 0; n < 1000; ++n) {
    const Pose X_BH{0.19 * draw(), from_rotation_vector(1.047 * draw())};
    REQUIRE(kDevice.solve(X_BH, q));
    REQUIRE(std::fabs(q[4]) <= tol(1.1));
  }
}

TEST_CASE("six motors: the planted jump is a turn of one radian", "[device-io]") {
  JointAngles q;
  REQUIRE(kDevice.solve({{}, from_rotation_vector({0.2, -0.3, 0.1})}, q));
  const MotorCounts here = kDevice.counts(q);
  MotorCounts jumped = here;
  for (size_t i = 0; i < 6; ++i) jumped[i] += kTurnJumpCounts[i];
  CHECK(pose_of(jumped).p == pose_of(here).p);
  CHECK(angle_between(pose_of(jumped).q, pose_of(here).q) == Approx(1).epsilon(1e-4));
}

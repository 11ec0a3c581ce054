// SPDX-License-Identifier: GPL-3.0-or-later
// The wrench that holds up an arm, by each driver's kinematics, against the slope of its potential
// energy, whose places are found without them.
#include <array>
#include <catch2/catch.hpp>

#include "device-io/falcon/falcon.h"
#include "device-io/falcon/kinematics.h"
#include "device-io/haply/haply.h"
#include "device-io/hidarm/hid_arm.h"
#include "device-io/motors/holding.h"
#include "device-io/owndevice/own_device_arm.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "tests/support/driver/known_weight.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

struct HeldArm {
  const char* name;
  Arm arm;
  Vec3 middle_B{}, reach_B{0.04, 0.05, 0.04};
  double turn = 0;  // of the handle [rad]
};

std::vector<HeldArm> held_arms() {
  return {{"woodenhaptics", woodenhaptics_arm()},
          {"hid arm", hid_arm({})},
          {"falcon", falcon_arm({}), {}, {0.028, 0.028, 0.028}},
          {"haply", haply_arm({}), {0, 0.075, 0}, {0.03, 0.015, 0}},
          {"polhem", polhem_arm(), {}, {0.04, 0.05, 0.04}, 0.4},
          {"six motors", six_motors_arm(), {}, {0.04, 0.05, 0.04}, 0.4},
          {"own device", own_device_arm(), {}, {0.04, 0.05, 0.04}, 0.4}};
}

/// The angles of a handle by Newton's method on the driver's own pose, where it has no solution.
JointAngles angles_of(const HeldArm& held, const Pose& X_BH) {
  JointAngles q{};
  if (held.arm.solve) {
    REQUIRE(held.arm.solve(X_BH, q));
    return q;
  }
  if (std::string_view(held.name) == "falcon") {
    FalconPose pose;
    REQUIRE(solve_falcon({}, X_BH.p, pose));
    return {pose.angles.x, pose.angles.y, pose.angles.z};
  }
  q = {2.2, 0.9};
  for (int n = 0; n < 50; ++n) {
    Pose at;
    HandleJacobian J{};
    REQUIRE(held.arm.find(q, at));
    REQUIRE(held.arm.jacobian(q, at, J));
    const Vec3 left = X_BH.p - at.p;
    const double area = J[0].v.x * J[1].v.y - J[0].v.y * J[1].v.x;
    q[0] += 0.5 * (left.x * J[1].v.y - left.y * J[1].v.x) / area;
    q[1] += 0.5 * (J[0].v.x * left.y - J[0].v.y * left.x) / area;
  }
  return q;
}

}  // namespace

TEST_CASE("holding: the wrench that holds an arm up is the slope of its potential energy") {
  const auto held = GENERATE(from_range(held_arms()));
  const std::string name = held.name;
  GravityConfig gravity = known_masses(name);
  // aside of upright: also what is level counts
  const bool is_tilted = GENERATE(false, true);
  if (is_tilted) gravity.down_B = normalized(Vec3{0.3, -0.7, name == "haply" ? 0.0 : -0.4});
  double largest = 0;
  for (const double x : {-1.0, 0.1, 1.0}) {
    for (const double y : {-1.0, 0.2, 1.0}) {
      for (const double z : {-1.0, 0.3, 1.0}) {
        const Vec3 aside{x * held.reach_B.x, y * held.reach_B.y, z * held.reach_B.z};
        const Pose X_BH{held.middle_B + aside, from_rotation_vector(held.turn * Vec3{x, y, z} / 2)};
        INFO(name << " at " << X_BH.p.x << " " << X_BH.p.y << " " << X_BH.p.z);
        const JointAngles q = angles_of(held, X_BH);
        const Wrench F_B = holding_wrench(held.arm, gravity, q, X_BH);
        Wrench pull_B = pull_of_weight(name, gravity, X_BH);
        // it moves in its plane
        if (held.arm.motors == 2) pull_B.f.z = 0;
        REQUIRE_THAT(F_B.f, IsNear(-1.0 * pull_B.f, 1e-6));
        REQUIRE_THAT(F_B.t, IsNear(-1.0 * pull_B.t, 1e-6));
        largest = std::max(largest, norm(F_B.f));
      }
    }
  }
  CHECK(largest > 0.4);
}

TEST_CASE("holding: without masses it is nothing, and down is the device's own") {
  const HeldArm falcon = held_arms()[2];
  FalconPose pose;
  REQUIRE(solve_falcon({}, {}, pose));
  const JointAngles q{pose.angles.x, pose.angles.y, pose.angles.z};
  CHECK(holding_wrench(falcon.arm, {}, q, {}) == Wrench{});
  GravityConfig gravity;
  gravity.handle.mass = 0.1;
  CHECK_THAT(holding_wrench(falcon.arm, gravity, q, {}).f, IsNear({0, 0.981, 0}, 1e-9));
  CHECK_THAT(holding_wrench(own_device_arm(), gravity, {}, {}).f, IsNear({0, 0, 0.981}, 1e-9));
}

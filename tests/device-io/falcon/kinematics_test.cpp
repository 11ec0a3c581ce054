// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "device-io/falcon/falcon.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;

namespace {

const FalconGeometry kFalcon;

}  // namespace

TEST_CASE("falcon: a count is 0.0364 degrees", "[device-io]") {
  const Arm arm = falcon_arm({});
  const double zero = arm.angles({})[0], one = arm.angles({1})[0];
  CHECK(arm.angles({1000})[0] - zero ==
        Approx(1000 * 0.0364347 * std::numbers::pi / 180).epsilon(1e-5));
  CHECK(zero == Approx(35 * std::numbers::pi / 180));
  // on the axis, 135 mm from the motors, all counts are about zero
  FalconPose pose;
  REQUIRE(solve_falcon(kFalcon, {0, 0, 0.010}, pose));
  for (int i = 0; i < 3; ++i) {
    CHECK(std::fabs(pose.angles[i] - zero) < 10 * (one - zero));
  }
}

TEST_CASE("falcon: angles of no place are said, and the place stays", "[device-io]") {
  Vec3 p_B{0.01, 0, 0};
  CHECK_FALSE(find_falcon_handle(kFalcon, {3, -3, 3}, p_B));
  CHECK_FALSE(find_falcon_handle(kFalcon, {std::nan(""), 0, 0}, p_B));
  CHECK_THAT(p_B, IsNear({0.01, 0, 0}, 0));
}

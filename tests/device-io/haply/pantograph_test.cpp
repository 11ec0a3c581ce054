// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/pantograph.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;

namespace {

const PantographGeometry kHaplyArm;

}  // namespace

// Places and torques of the formulas in Haply-API-cpp (c336a06), Pantograph.cpp, evaluated in
// double: angles [degrees], the handle from the axis of motor 1 [m], and the torques of 1 along x
// and y. Its torques lack the length of the driven links and have a gain of 0.1: 2 N·m of its make
// 1 N·m.
TEST_CASE("pantograph: places and torques are those of hAPI", "[device-io]") {
  struct Row {
    double angle_1, angle_2, x, y, tx_1, tx_2, ty_1, ty_2;
  };
  for (const Row& row : {
           Row{180, 0, 0.010000000, 0.036055513, -0.030046261, -0.030046261, -0.050000000,
               0.050000000},
           Row{150, 30, 0.010000000, 0.070375925, -0.061862821, -0.061862821, -0.072667762,
               0.072667762},
           Row{135, 20, 0.024047791, 0.072385976, -0.077344363, -0.050626568, -0.060069175,
               0.081213202},
           Row{165, 60, -0.017100349, 0.075605242, -0.045234779, -0.089448156, -0.086958210,
               0.044529659},
           Row{120, 60, 0.010000000, 0.103923048, -0.086602540, -0.086602540, -0.050000000,
               0.050000000},
           Row{140, -5, 0.028726289, 0.052318050, -0.071694738, -0.023056607, -0.051970417,
               0.076588303},
       }) {
    CAPTURE(row.angle_1, row.angle_2);
    const PantographAngles angles{row.angle_1 * kDegree, row.angle_2 * kDegree};
    Vec3 p_B;
    REQUIRE(find_pantograph_handle(kHaplyArm, angles, p_B));
    CHECK_THAT(p_B, IsNear({row.x - 0.01, row.y, 0}, 2e-9));
    std::array<Vec3, 2> J;
    REQUIRE(pantograph_jacobian(kHaplyArm, angles, p_B, J));
    constexpr double kGain = 0.1 / 0.05;
    CHECK_THAT(kGain * J[0], IsNear({row.tx_1, row.ty_1, 0}, 2e-9));
    CHECK_THAT(kGain * J[1], IsNear({row.tx_2, row.ty_2, 0}, 2e-9));
  }
}

TEST_CASE("pantograph: out of reach and singular are said, and nothing changes", "[device-io]") {
  Vec3 p_B{1, 2, 3};
  // elbows farther apart than two distal links, or in one line with them
  CHECK_FALSE(find_pantograph_handle({0.07, 0.07, 0.02}, {std::numbers::pi, 0}, p_B));
  CHECK_FALSE(find_pantograph_handle({0.06, 0.07, 0.02}, {std::numbers::pi, 0}, p_B));
  // elbows that meet
  CHECK_FALSE(find_pantograph_handle({0.05, 0.07, 0}, {1.5, 1.5}, p_B));
  CHECK_FALSE(find_pantograph_handle(kHaplyArm, {std::nan(""), 0}, p_B));
  CHECK_THAT(p_B, IsNear({1, 2, 3}, 0));
}

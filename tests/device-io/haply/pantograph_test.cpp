// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/pantograph.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;

namespace {

constexpr double kDegree = std::numbers::pi / 180;
const PantographGeometry kHaplyArm;

/// Calls visit(p_B) on a grid over the workspace, a disc of 35 mm before the motors.
template <typename Visit>
void sweep_workspace(Visit visit) {
  constexpr int kN = 30;
  constexpr double kRadius = 0.035;
  for (int i = -kN; i <= kN; ++i) {
    for (int j = -kN; j <= kN; ++j) {
      if (i * i + j * j > kN * kN) continue;
      visit(Vec3{0, 0.07, 0} + kRadius / kN * Vec3{double(i), double(j), 0});
    }
  }
}

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

TEST_CASE("pantograph: forward after inverse is the identity over the workspace", "[device-io]") {
  double worst = 0;
  int places = 0;
  // other proportions: motors on one axis; short driven links
  for (const PantographGeometry& g :
       {kHaplyArm, PantographGeometry{0.07, 0.09, 0}, PantographGeometry{0.06, 0.09, 0.05}}) {
    sweep_workspace([&](const Vec3& p_B) {
      PantographAngles angles;
      REQUIRE(solve_pantograph(g, p_B, angles));
      Vec3 found;
      REQUIRE(find_pantograph_handle(g, angles, found));
      worst = std::max(worst, norm(found - p_B));
      ++places;
    });
  }
  CAPTURE(places, worst);
  CHECK(places > 8000);
  CHECK(worst < 1e-9);
}

TEST_CASE("pantograph: each link keeps its length", "[device-io]") {
  sweep_workspace([&](const Vec3& p_B) {
    PantographAngles angles;
    REQUIRE(solve_pantograph(kHaplyArm, p_B, angles));
    for (int i = 0; i < 2; ++i) {
      const double theta = angles[static_cast<size_t>(i)];
      const Vec3 elbow{(i == 0 ? -0.01 : 0.01) + 0.05 * std::cos(theta), 0.05 * std::sin(theta), 0};
      CHECK(norm(p_B - elbow) == Approx(0.07).epsilon(1e-12));
    }
    // elbows outwards
    CHECK(-0.01 + 0.05 * std::cos(angles[0]) < p_B.x);
    CHECK(0.01 + 0.05 * std::cos(angles[1]) > p_B.x);
  });
}

TEST_CASE("pantograph: the Jacobian is the derivative of the place", "[device-io]") {
  constexpr double kStep = 1e-6;
  double worst = 0;
  sweep_workspace([&](const Vec3& p_B) {
    PantographAngles angles;
    REQUIRE(solve_pantograph(kHaplyArm, p_B, angles));
    std::array<Vec3, 2> J;
    REQUIRE(pantograph_jacobian(kHaplyArm, angles, p_B, J));
    for (size_t i = 0; i < 2; ++i) {
      PantographAngles plus = angles, minus = angles;
      plus[i] += kStep;
      minus[i] -= kStep;
      Vec3 after, before;
      REQUIRE(find_pantograph_handle(kHaplyArm, plus, after));
      REQUIRE(find_pantograph_handle(kHaplyArm, minus, before));
      worst = std::max(worst, norm(J[i] - (after - before) / (2 * kStep)));
    }
  });
  CAPTURE(worst);
  CHECK(worst < 1e-8);
}

TEST_CASE("pantograph: a count moves the handle by 10 to 50 um", "[device-io]") {
  sweep_workspace([&](const Vec3& p_B) {
    PantographAngles angles;
    REQUIRE(solve_pantograph(kHaplyArm, p_B, angles));
    std::array<Vec3, 2> J;
    REQUIRE(pantograph_jacobian(kHaplyArm, angles, p_B, J));
    for (const Vec3& way : J) {
      const double moved = norm(way) * 360 * kDegree / 13'824;
      CHECK(moved > 10e-6);
      CHECK(moved < 50e-6);
    }
  });
}

TEST_CASE("pantograph: out of reach and singular are said, and nothing changes", "[device-io]") {
  PantographAngles angles{1, 2};
  CHECK_FALSE(solve_pantograph(kHaplyArm, {0, 0.2, 0}, angles));
  CHECK_FALSE(solve_pantograph(kHaplyArm, {-0.01, 0.001, 0}, angles));
  CHECK_FALSE(solve_pantograph(kHaplyArm, {std::nan(""), 0.05, 0}, angles));
  CHECK(angles == PantographAngles{1, 2});
  Vec3 p_B{1, 2, 3};
  // elbows farther apart than two distal links, or in one line with them
  CHECK_FALSE(find_pantograph_handle({0.07, 0.07, 0.02}, {std::numbers::pi, 0}, p_B));
  CHECK_FALSE(find_pantograph_handle({0.06, 0.07, 0.02}, {std::numbers::pi, 0}, p_B));
  // elbows that meet
  CHECK_FALSE(find_pantograph_handle({0.05, 0.07, 0}, {1.5, 1.5}, p_B));
  CHECK_FALSE(find_pantograph_handle(kHaplyArm, {std::nan(""), 0}, p_B));
  CHECK_THAT(p_B, IsNear({1, 2, 3}, 0));
}

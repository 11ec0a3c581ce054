// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;

namespace {

const FalconGeometry kFalcon;
constexpr double kWorkspace = 0.05;  // radius [m]

/// Calls visit(p_B) on a grid over the workspace.
template <typename Visit>
void sweep_workspace(Visit visit) {
  constexpr int kN = 8;
  for (int i = -kN; i <= kN; ++i) {
    for (int j = -kN; j <= kN; ++j) {
      for (int k = -kN; k <= kN; ++k) {
        const Vec3 p_B = kWorkspace / kN * Vec3{double(i), double(j), double(k)};
        if (norm(p_B) <= kWorkspace) visit(p_B);
      }
    }
  }
}

}  // namespace

TEST_CASE("falcon: forward after inverse is the identity over the workspace", "[device-io]") {
  double worst = 0;
  int places = 0;
  sweep_workspace([&](const Vec3& p_B) {
    FalconPose pose;
    REQUIRE(solve_falcon(kFalcon, p_B, pose));
    Vec3 found;  // from the middle: the worst start
    REQUIRE(find_falcon_handle(kFalcon, pose.angles, found));
    worst = std::max(worst, norm(found - p_B));
    ++places;
  });
  CAPTURE(places, worst);
  CHECK(places > 2000);
  CHECK(worst < 1e-9);
}

TEST_CASE("falcon: each leg closes: knee and ankle are a rod apart", "[device-io]") {
  // in space: a parallelogram keeps the plate parallel, so the rod's length is that between the
  // joints' middles
  sweep_workspace([&](const Vec3& p_B) {
    FalconPose pose;
    REQUIRE(solve_falcon(kFalcon, p_B, pose));
    for (int i = 0; i < 3; ++i) {
      const double phi = std::numbers::pi / 180 * (105 - 120 * i);
      const Vec3 out{std::cos(phi), std::sin(phi), 0}, side{-std::sin(phi), std::cos(phi), 0};
      const Vec3 up{0, 0, 1};
      const double theta = pose.angles[i];
      const Vec3 knee = 0.040 * out - 0.02309 * side +
                        0.060 * (std::cos(theta) * out + std::sin(theta) * up) - 0.125 * up;
      const Vec3 ankle = p_B + 0.01443 * out - 0.025 * side;
      // the two ends of the rod stand off by d and e within the leg's plane
      const Vec3 leg = ankle - knee;
      const double across = dot(leg, side);
      const double within = norm(leg - across * side) - 2 * 0.01125;
      CHECK(std::hypot(within, across) == Approx(0.1025).epsilon(1e-12));
    }
  });
}

TEST_CASE("falcon: the Jacobian is the derivative of the angles", "[device-io]") {
  constexpr double kStep = 1e-6;
  sweep_workspace([&](const Vec3& p_B) {
    FalconPose pose, plus, minus;
    REQUIRE(solve_falcon(kFalcon, p_B, pose));
    for (int k = 0; k < 3; ++k) {
      Vec3 step;
      step[k] = kStep;
      REQUIRE(solve_falcon(kFalcon, p_B + step, plus));
      REQUIRE(solve_falcon(kFalcon, p_B - step, minus));
      const Vec3 slope = (plus.angles - minus.angles) / (2 * kStep);
      CHECK_THAT(pose.J.column(k), IsNear(slope, 2e-5 * (1 + norm(slope))));
    }
  });
}

TEST_CASE("falcon: torques do the work of the force", "[device-io]") {
  sweep_workspace([&](const Vec3& p_B) {
    FalconPose pose;
    REQUIRE(solve_falcon(kFalcon, p_B, pose));
    for (const Vec3& F_B : {Vec3{3, 0, 0}, Vec3{0, -2, 0}, Vec3{0, 0, 8}, Vec3{1, 2, -3}}) {
      Vec3 torques;
      REQUIRE(falcon_torques(pose, F_B, torques));
      const Vec3 motion{1e-6, -2e-6, 1.5e-6};
      FalconPose moved;
      REQUIRE(solve_falcon(kFalcon, p_B + motion, moved));
      const double work = dot(torques, moved.angles - pose.angles);
      CHECK(work == Approx(dot(F_B, motion)).margin(1e-3 * norm(F_B) * norm(motion)));
      CHECK_THAT(falcon_force(pose, torques), IsNear(F_B, 1e-9));
    }
  });
}

TEST_CASE("falcon: a count is 0.0364 degrees and moves the handle by 20 to 50 um", "[device-io]") {
  CHECK(falcon_angle(kFalcon, 1000) - falcon_angle(kFalcon, 0) ==
        Approx(1000 * 0.0364347 * std::numbers::pi / 180).epsilon(1e-5));
  CHECK(falcon_angle(kFalcon, 0) == Approx(35 * std::numbers::pi / 180));
  // on the axis, 135 mm from the motors, all counts are about zero
  FalconPose pose;
  REQUIRE(solve_falcon(kFalcon, {0, 0, 0.010}, pose));
  for (int i = 0; i < 3; ++i) {
    CHECK(std::fabs(pose.angles[i] - falcon_angle(kFalcon, 0)) <
          10 * (falcon_angle(kFalcon, 1) - falcon_angle(kFalcon, 0)));
  }
  sweep_workspace([&](const Vec3& p_B) {
    if (!solve_falcon(kFalcon, p_B, pose)) return;
    Vec3 next = p_B;
    const Vec3 one{kFalcon.angle_per_count, 0, 0};
    REQUIRE(find_falcon_handle(kFalcon, pose.angles + one, next));
    const double moved = norm(next - p_B);
    CHECK(moved > 10e-6);
    CHECK(moved < 60e-6);
  });
}

TEST_CASE("falcon: out of reach is said, and the place stays", "[device-io]") {
  FalconPose pose;
  CHECK_FALSE(solve_falcon(kFalcon, {0.2, 0, 0}, pose));
  CHECK_FALSE(solve_falcon(kFalcon, {0, 0, std::nan("")}, pose));
  Vec3 p_B{0.01, 0, 0};
  CHECK_FALSE(find_falcon_handle(kFalcon, {3, -3, 3}, p_B));
  CHECK_FALSE(find_falcon_handle(kFalcon, {std::nan(""), 0, 0}, p_B));
  CHECK_THAT(p_B, IsNear({0.01, 0, 0}, 0));
}

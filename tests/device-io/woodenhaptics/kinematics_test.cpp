// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/near.h"
#include "tests/support/tip.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::kAlgebra;
using haptic::test::tip_at;

TEST_CASE("woodenhaptics: at home the upper arm stands and the forearm lies", "[device-io]") {
  // x = Lc − 0.22, z = La + Lb − 0.08, by hand from the lengths of the device
  const JointAngles home = woodenhaptics_arm().angles({});
  CHECK_THAT((Vec3{home[0], home[1], home[2]}), IsNear({0, 0, std::numbers::pi / 2}, kAlgebra));
  CHECK_THAT(tip_at({0, 0, 0}), IsNear({0.025, 0, 0.205}, kAlgebra));
}

TEST_CASE("woodenhaptics: encoder counts turn the bodies as the reference says", "[device-io]") {
  // a quarter turn of body A: 2000 · 16 / 4 counts. The tip goes round to +y
  CHECK_THAT(tip_at({8000, 0, 0}), IsNear({-0.220, 0.245, 0.205}, kAlgebra));
  // motor B turns against its body: −3000 counts of 24000 lean the upper arm 45° forward
  const double s = std::sqrt(0.5);
  CHECK_THAT(tip_at({0, -3000, 0}), IsNear({0.205 * s + 0.025, 0, 0.205 * s}, kAlgebra));
  // and so does C: 3000 counts let the forearm hang 45° down
  CHECK_THAT(tip_at({0, 0, 3000}), IsNear({0.245 * s - 0.220, 0, 0.205 - 0.245 * s}, kAlgebra));
}

TEST_CASE("woodenhaptics: one count moves the tip by what the reference gives", "[device-io]") {
  // 2π · 0.245 / 2000 / 12 = 64 µm
  const Vec3 before = tip_at({0, 0, 0});
  const Vec3 after = tip_at({0, 0, 1});
  CHECK(norm(after - before) == Approx(64.14e-6).epsilon(1e-3));
}

TEST_CASE("woodenhaptics: a place out of reach is refused, a stretched arm pushes nothing",
          "[device-io]") {
  const Arm& arm = woodenhaptics_arm();
  JointAngles q;
  CHECK_FALSE(arm.solve({Vec3{0, 0, 0.08} - WoodenHapticsGeometry{}.origin, {}}, q));
  CHECK(arm.wrench({0, std::numbers::pi / 2, std::numbers::pi / 2}, {1, 1, 1}) == Wrench{});
}

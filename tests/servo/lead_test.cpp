// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/lead.cpp.
#include "servo/lead.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "proto/math/units.h"
#include "tests/support/near.h"

using haptic::Clutch;
using haptic::ControlFrame;
using haptic::DeviceMap;
using haptic::kMs;
using haptic::led_handle;
using haptic::Vec3;
using haptic::test::IsNear;

namespace {

ControlFrame led_to(const Vec3& tool_W, int64_t t_ns) {
  ControlFrame control{};
  control.leading = 1;
  control.X_WT_intent.p = tool_W;
  control.intent_t_ns = t_ns;
  return control;
}

}  // namespace

TEST_CASE("lead: it ends 200 ms after the last command, by the tick's own clock", "[servo]") {
  const ControlFrame control = led_to({0.1, 0, 0}, 5000 * kMs);
  const auto at = [&](int64_t now_ns) { return led_handle({}, {}, &control, now_ns).has_value(); };
  CHECK(at(5000 * kMs));
  CHECK(at(5200 * kMs));
  CHECK_FALSE(at(5200 * kMs + 1));
  CHECK_FALSE(at(9000 * kMs));
  // a command may come after the tick has woken up; one of another clock is none
  CHECK(at(4990 * kMs));
  CHECK_FALSE(at(4000 * kMs));
}

TEST_CASE("lead: nobody leads without a command, or to what is no place", "[servo]") {
  ControlFrame control = led_to({0.1, 0, 0}, 0);
  CHECK(led_handle({}, {}, &control, 0));
  CHECK_FALSE(led_handle({}, {}, nullptr, 0));
  control.leading = 0;
  CHECK_FALSE(led_handle({}, {}, &control, 0));
  control = led_to({std::numeric_limits<double>::quiet_NaN(), 0, 0}, 0);
  CHECK_FALSE(led_handle({}, {}, &control, 0));
  control = led_to({std::numeric_limits<double>::infinity(), 0, 0}, 0);
  CHECK_FALSE(led_handle({}, {}, &control, 0));
}

TEST_CASE("lead: a handle at the answer has its tool at the pose", "[servo]") {
  DeviceMap map;
  map.X_WB = {{0.3, -0.1, 0.2}, haptic::from_rotation_vector({0.4, -0.7, 1.1})};
  map.motion_scale = 2.5;
  map.X_HT = {{0.01, 0.02, -0.15}, haptic::from_rotation_vector({0.3, 0, 0.2})};
  Clutch clutch;
  clutch.offset_W = {0.05, 0, -0.02};
  ControlFrame control = led_to({0.2, 0.4, -0.1}, 0);
  control.X_WT_intent.q = haptic::from_rotation_vector({-0.2, 0.5, 0.1});
  const auto X_BH = led_handle(map, clutch, &control, 0);
  REQUIRE(X_BH);
  const haptic::Pose X_WT = tool_pose(map, clutch, *X_BH);
  CHECK_THAT(X_WT.p, IsNear(control.X_WT_intent.p, 1e-15));
  CHECK(std::fabs(dot(X_WT.q, control.X_WT_intent.q)) == Approx(1).epsilon(1e-15));
}

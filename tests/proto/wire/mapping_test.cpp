// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/wire/mapping.cpp.
#include "proto/wire/mapping.h"

#include <random>

#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

DeviceMap sample_map() {
  DeviceMap map;
  map.X_WB = {{0.3, -0.1, 0.2}, haptic::from_rotation_vector({0.4, -0.7, 1.1})};
  map.motion_scale = 2.5;
  map.force_scale = 0.6;
  map.X_HT = {{0.01, 0.02, -0.15}, haptic::from_rotation_vector({0.3, 0, 0.2})};
  return map;
}
const Pose kHandle{{0.02, 0.05, -0.03}, haptic::from_rotation_vector({-0.2, 0.5, 0.1})};

}  // namespace

TEST_CASE("mapping: identity map leaves the pose alone to the bit", "[mapping]") {
  const Pose X_WT = tool_pose(DeviceMap{}, Clutch{}, kHandle);
  CHECK(X_WT.p == kHandle.p);
}

TEST_CASE("mapping: the tool's twist is the derivative of its pose", "[mapping]") {
  const DeviceMap map = sample_map();
  const Twist V_BH{{0.1, -0.2, 0.05}, {0.7, 0.3, -1.2}};
  const double h = 1e-6;
  const Pose after = tool_pose(map, {}, extrapolate(kHandle, V_BH, h));
  const Pose before = tool_pose(map, {}, extrapolate(kHandle, V_BH, -h));
  const Twist V_WT = tool_twist(map, kHandle, V_BH);
  CHECK_THAT(V_WT.v, IsNear((after.p - before.p) / (2 * h), 1e-7));
  const Vec3 turned = to_rotation_vector(after.q * conjugate(before.q)) / (2 * h);
  CHECK_THAT(V_WT.w, IsNear(turned, 1e-7));
}

TEST_CASE("mapping: power at the handle is the scene's power by scale", "[mapping]") {
  // rotations are not scaled, so with s ≠ 1 only the force part carries the motion scale
  DeviceMap map = sample_map();
  const Twist V_BH{{0.1, -0.2, 0.05}, {}};
  const Wrench F_W{{1, -2, 3}, {0.1, 0.2, -0.3}};
  const Wrench F_B = device_wrench(map, kHandle, F_W);
  const Twist V_WT = tool_twist(map, kHandle, V_BH);
  const double scene_power = dot(F_W.f, V_WT.v);
  const double device_power = dot(F_B.f, V_BH.v);
  CHECK(std::fabs(device_power * map.motion_scale / map.force_scale - scene_power) <= tol(1e-12));
}

TEST_CASE("mapping: tool on the grip transfers its torque arm", "[mapping][trap]") {
  // virtual work for a pure rotation of the handle: the arm must be world R·r, not r
  const DeviceMap map = sample_map();
  const Twist V_BH{{}, {0.7, 0.3, -1.2}};
  const Wrench F_W{{1, -2, 3}, {0.1, 0.2, -0.3}};
  const Wrench F_B = device_wrench(map, kHandle, F_W);
  const Twist V_WT = tool_twist(map, kHandle, V_BH);
  const double scene_power = dot(F_W.f, V_WT.v) + dot(F_W.t, V_WT.w);
  CHECK(std::fabs(dot(F_B.t, V_BH.w) / map.force_scale - scene_power) <= tol(1e-12));
}

TEST_CASE("mapping: the device feels stiffness s times phi times K", "[mapping]") {
  const DeviceMap map = sample_map();
  const double stiffness = 1000;
  const Vec3 push_B{1e-3, 0, 0};
  const Pose pushed{kHandle.p + push_B, kHandle.q};
  const Vec3 moved_W = tool_pose(map, {}, pushed).p - tool_pose(map, {}, kHandle).p;
  const Wrench F_B = device_wrench(map, pushed, Wrench{-stiffness * moved_W, {}});
  const double felt = map.motion_scale * map.force_scale * stiffness;
  CHECK_THAT(F_B.f, IsNear(-felt * push_B, 1e-9));
}

TEST_CASE("mapping: clutching moves the workspace and never the tool", "[mapping]") {
  DeviceMap map = sample_map();
  map.clutch_button = 3;
  Clutch clutch;
  DeviceState device{};
  device.X_BH = kHandle;
  Pose X_WT = apply_clutch(map, clutch, device, tool_pose(map, clutch, kHandle));
  const Vec3 before = X_WT.p;

  // hold the button and move the hand away: the tool stays
  device.buttons = 1u << 3;
  for (int i = 0; i < 5; ++i) {
    device.X_BH.p += Vec3{0.01, 0, 0.002};
    X_WT = apply_clutch(map, clutch, device, X_WT);
    CHECK_THAT(X_WT.p, IsNear(before, 1e-12));
    CHECK(clutch.held);
  }
  // release it: no jump, then the hand moves the tool from the new place
  device.buttons = 0;
  X_WT = apply_clutch(map, clutch, device, X_WT);
  CHECK_THAT(X_WT.p, IsNear(before, 1e-12));
  CHECK_FALSE(clutch.held);
  device.X_BH.p += Vec3{0.001, 0, 0};
  const Pose moved = apply_clutch(map, clutch, device, X_WT);
  CHECK(norm(moved.p - before) == Approx(map.motion_scale * 0.001).epsilon(1e-9));
}

// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/mapping.h"

#include "proto/math/assert.h"

namespace haptic {

Pose tool_pose(const DeviceMap& map, const Clutch& clutch, const Pose& X_BH) {
  HAPTIC_ASSERT(map.motion_scale > 0);
  HAPTIC_ASSERT(is_unit(map.X_WB.q) && is_unit(map.X_HT.q));
  const Pose X_WH = map.X_WB * Pose{map.motion_scale * X_BH.p, X_BH.q};
  return Pose{X_WH.p + clutch.offset_W, X_WH.q} * map.X_HT;
}

Pose handle_pose(const DeviceMap& map, const Clutch& clutch, const Pose& X_WT) {
  HAPTIC_ASSERT(map.motion_scale > 0);
  const Quat q_WH = X_WT.q * conjugate(map.X_HT.q);
  const Vec3 p_WH = X_WT.p - rotate(q_WH, map.X_HT.p) - clutch.offset_W;
  return {(inverse(map.X_WB) * p_WH) / map.motion_scale, conjugate(map.X_WB.q) * q_WH};
}

Twist tool_twist(const DeviceMap& map, const Pose& X_BH, const Twist& V_BH) {
  const Twist V_WH{map.motion_scale * rotate(map.X_WB.q, V_BH.v), rotate(map.X_WB.q, V_BH.w)};
  const Vec3 arm_W = rotate(map.X_WB.q * X_BH.q, map.X_HT.p);
  return {velocity_at(V_WH, arm_W), V_WH.w};
}

Wrench device_wrench(const DeviceMap& map, const Pose& X_BH, const Wrench& F_W) {
  HAPTIC_ASSERT(map.force_scale > 0);
  const Vec3 arm_W = rotate(map.X_WB.q * X_BH.q, map.X_HT.p);
  const Wrench at_handle_W = map.force_scale * shift(F_W, arm_W);
  const Quat q_BW = conjugate(map.X_WB.q);
  return {rotate(q_BW, at_handle_W.f), rotate(q_BW, at_handle_W.t)};
}

Pose apply_clutch(const DeviceMap& map, Clutch& clutch, const DeviceState& device,
                  const Pose& X_WT_last) {
  HAPTIC_ASSERT(map.clutch_button < 32);
  const bool pressed = is_pressed(device, map.clutch_button);
  const Pose X_WT = tool_pose(map, clutch, device.X_BH);
  if (!pressed && !clutch.held) return X_WT;

  // the tool stays in place: the workspace moves instead
  clutch.held = pressed;
  clutch.offset_W += X_WT_last.p - X_WT.p;
  return {X_WT_last.p, X_WT.q};
}

}  // namespace haptic

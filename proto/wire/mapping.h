// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/wire/wire.h"

namespace haptic {

/// Placement of the device's workspace in the scene. A stiffness K in the scene is felt as s·φ·K at
/// the device, so limits are applied after this map, in device units.
struct DeviceMap {
  Pose X_WB;                   // device base in the scene (places and turns the workspace)
  double motion_scale = 1;     // s: scene metres per device metre
  double force_scale = 1;      // φ: device newtons per scene newton
  Pose X_HT;                   // tool on the grip, in scene metres; lever arm of the torque
  int32_t clutch_button = -1;  // bit that re-indexes the workspace while held; −1: none
  int32_t grasp_button = -1;   // bit that holds the touched object while held; −1: none
};

/// True if a button of the device is down; −1: there is no such button.
constexpr bool is_pressed(const DeviceState& device, int32_t button) {
  return button >= 0 && ((device.buttons >> button) & 1u) != 0;
}

/// Re-indexing: displacement of the workspace by the clutch.
struct Clutch {
  Vec3 offset_W;  // added to the handle's scene position [m]
  bool held = false;
};

/// X_WT of a device pose: p_WH = X_WB · (s·p_BH) + offset; the orientation is not scaled.
Pose tool_pose(const DeviceMap& map, const Clutch& clutch, const Pose& X_BH);

/// The inverse: X_BH of a handle whose tool is at X_WT.
Pose handle_pose(const DeviceMap& map, const Clutch& clutch, const Pose& X_WT);

/// V_WT: velocity of the tool's origin and its angular velocity, in W.
Twist tool_twist(const DeviceMap& map, const Pose& X_BH, const Twist& V_BH);

/// Wrench at the handle's origin, in B, that renders the wrench F_W acting on the tool at the
/// tool's origin: force φ·f, torque φ·(τ + r×f), with r from handle to tool.
Wrench device_wrench(const DeviceMap& map, const Pose& X_BH, const Wrench& F_W);

/// One tick of the clutch. While the button is held the tool's position stays at X_WT_last and its
/// orientation follows the hand; on release the offset prevents a jump. Returns the tool pose.
Pose apply_clutch(const DeviceMap& map, Clutch& clutch, const DeviceState& device,
                  const Pose& X_WT_last);

}  // namespace haptic

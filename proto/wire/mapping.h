// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/wire/wire.h"

namespace haptic {

/// How the device's workspace lies in the scene. With motion scale s and force scale φ the device
/// feels the stiffness s·φ·K: limits are taken in device units, after this map.
struct DeviceMap {
  Pose X_WB;                   // device base in the scene (turns and places the workspace)
  double motion_scale = 1;     // s: scene metres per device metre
  double force_scale = 1;      // φ: device newtons per scene newton
  Pose X_HT;                   // tool on the grip, in scene metres; carries the torque arm
  int32_t clutch_button = -1;  // bit that re-indexes the workspace while held; −1: none
  uint32_t reserved = 0;
};

/// Re-indexing: where the workspace was moved to by clutching.
struct Clutch {
  Vec3 offset_W;  // added to the handle's scene position [m]
  bool held = false;
};

/// X_WT of a device pose: p_WH = X_WB · (s·p_BH) + offset; the orientation is not scaled.
Pose tool_pose(const DeviceMap& map, const Clutch& clutch, const Pose& X_BH);

/// V_WT: velocity of the tool's origin and its angular velocity, in W.
Twist tool_twist(const DeviceMap& map, const Pose& X_BH, const Twist& V_BH);

/// Wrench at the handle's origin, in B, that renders the wrench F_W acting on the tool at the
/// tool's origin: force φ·f, torque φ·(τ + r×f), with r from handle to tool.
Wrench device_wrench(const DeviceMap& map, const Pose& X_BH, const Wrench& F_W);

/// One tick of the clutch. While the button is held the tool stays at X_WT_last; at release the
/// offset is such that it does not jump. Returns the tool pose to use.
Pose apply_clutch(const DeviceMap& map, Clutch& clutch, const DeviceState& device,
                  const Pose& X_WT_last);

}  // namespace haptic

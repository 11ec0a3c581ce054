// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/spacemouse/report.h"
#include "proto/config/device_config.h"
#include "proto/math/pose.h"

namespace haptic {

/// The velocity that a deflected knob commands, in B: x to the right, y up, z to the user. A count
/// of the raw axes (x right, y to the user, z down) is deflection d = count / full_scale, cut to
/// [−1, 1]; below the dead band b nothing, above it sign d · (|d| − b) / (1 − b), without a step;
/// times speed or turn_rate.
Twist commanded_velocity(const SpaceMouseInput& input, const RateDeviceConfig& config) noexcept;

/// The ball of handle positions and the cone of orientations of a device; 0: without an edge.
struct HandleRange {
  Vec3 centre_B;
  double radius = 0;  // [m]
  Quat rest_B;
  double turn = 0;  // [rad]
};

/// X_BH moved by V_BH for dt [s], turning about the handle itself, then put back into its range: to
/// the nearest place on the ball, along the shortest rotation.
Pose moved_within(const Pose& X_BH, const Twist& V_BH, double dt, const HandleRange& range);

}  // namespace haptic

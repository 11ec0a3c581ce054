// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "servo/render/render.h"

namespace haptic {

/// Limits are the smaller of the device's and the config's.
struct ActuatorLimits {
  double max_force = 0;
  double max_torque = 0;
  bool is_admittance = false;  // the device measures the hand's wrench and is commanded a pose
};
ServoModel build_servo_model(const SessionConfig& config, const ActuatorLimits& device);

}  // namespace haptic

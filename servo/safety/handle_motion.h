// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "proto/wire/wire.h"
#include "servo/safety/limits.h"

namespace haptic {

/// The last fresh sample of a device whose place is known.
struct LastSample {
  Pose X_BH;
  int64_t measured_ns = 0;  // its instant
  bool known = false;
};

/// How fast the handle is, of what can be felt: where neither torque is rendered nor the tool lies
/// off the handle, turning changes nothing that is felt, and no limit holds for it.
struct HandleSpeed {
  double moving = 0;   // [m/s]
  double turning = 0;  // [rad/s]
};
HandleSpeed speed_of(const SafetyLimits& limits, const HandleStiffness& stiffness,
                     const Twist& V_BH);

/// Whether either speed is above its limit.
bool is_too_fast(const SafetyLimits& limits, const HandleSpeed& speed);
/// Whether both are slow enough to start again: below 0.1 m/s and 1 rad/s.
bool is_calm(const HandleSpeed& speed);

/// What one sample says.
struct HandleStep {
  HandleMotion motion;
  bool jumped = false;  // farther than the hand can have moved
};

/// Compares a sample that is finite with the last fresh one. It has jumped where it is farther away
/// than twice a velocity limit allows in the time up to `now_ns`, plus 2 mm or 20 mrad. Homing, and
/// a device that comes back, move the pose rightly.
HandleStep follow_handle(const SafetyLimits& limits, const HandleStiffness& stiffness,
                         LastSample& last, const DeviceState& device, int64_t now_ns);

}  // namespace haptic

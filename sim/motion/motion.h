// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Pose and velocity of a scripted object at one instant.
struct ScriptedState {
  Pose X_WO;
  Twist V_WO;  // of the object's origin, in W
};

/// A scripted motion by its phase [rad]. The axis is fixed in the object's configured pose; a zero
/// axis or rate leaves the object at rest.
struct Motion {
  /// At a phase that grows at phase_rate [rad/s]; the twist is the exact derivative of the pose.
  ScriptedState (*state_at)(const ObjectConfig& object, double phase, double phase_rate);
  /// At which state_at has this pose; of two, the one that moves along V_WO.
  double (*phase_of)(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO);
};

}  // namespace haptic

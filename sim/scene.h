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

/// State of a scripted object at a phase [rad] that grows at phase_rate [rad/s]. Oscillate: p = p₀
/// + amplitude·sin(phase)·axis; spin: rotated by phase about the axis through its origin. The axis
/// is fixed in the object's configured pose; a zero axis or rate leaves the object at rest. The
/// twist is the exact derivative of the pose.
ScriptedState scripted_state(const ObjectConfig& object, double phase, double phase_rate);

/// The phase [rad] at which scripted_state has this pose; of an oscillation's two phases the one
/// that moves along V_WO. Zero for an object that cannot move.
double phase_of(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO);

/// Phase rate in scene time: 2π·frequency [rad/s].
double phase_speed(const MotionConfig& motion);

}  // namespace haptic

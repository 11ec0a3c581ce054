// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "proto/wire/wire.h"

namespace haptic {

/// Where a scripted object is, and how it moves, at one instant.
struct ScriptedState {
  Pose X_WO;
  Twist V_WO;  // of the object's origin, in W
};

/// State of a scripted object at a phase [rad] that grows with phase_rate [rad/s]. Oscillate:
/// p = p₀ + amplitude·sin(phase)·axis, spin: turned by phase about the axis through its origin. The
/// axis is fixed in the configured pose of the object; a zero axis or rate leaves it at rest. The
/// twist is the exact derivative of the pose.
ScriptedState scripted_state(const ObjectConfig& object, double phase, double phase_rate);

/// The phase [rad] at which scripted_state has this pose; of the two phases of an oscillation the
/// one that moves the way V_WO says. Zero for an object that cannot move.
double phase_of(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO);

/// Phase per second of scene time: 2π·frequency [rad/s].
double phase_speed(const MotionConfig& motion);

}  // namespace haptic

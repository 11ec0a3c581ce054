// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "sim/motion/motion.h"

namespace haptic {

/// State of a scripted object at a phase [rad] that grows at phase_rate [rad/s], by its motion.
ScriptedState scripted_state(const ObjectConfig& object, double phase, double phase_rate);

/// The phase [rad] at which scripted_state has this pose; of an oscillation's two phases the one
/// that moves along V_WO. Zero for an object that cannot move.
double phase_of(const ObjectConfig& object, const Pose& X_WO, const Twist& V_WO);

/// Phase rate in scene time: 2π·frequency [rad/s].
double phase_speed(const MotionConfig& motion);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/arm.h"

namespace haptic {

/// An arm of three joints that carries the handle in a wrist of three, whose axes meet in the
/// handle's origin: a device that does not exist yet, with a WoodenHaptics as its arm and guessed
/// motors in its wrist (docs/six-motors.md, whose line it speaks). All motors at home: upper arm
/// upright, forearm level, handle as B.
///
/// Joint angles (θ_A, β, γ; pitch, roll, yaw) [rad]. The wrist hangs on the forearm: pitch turns
/// about the axis of the elbow, roll about the axis that pitch carries, level where the handle is
/// upright, yaw about the handle's own z. With R(axis, angle) right-handed
///   q_BH = R(z, θ_A) R(y, ψ) R(x, roll) R(z, yaw),  ψ = pitch − γ,
/// so that a handle kept still turns the wrist against the arm. The wrist is singular at roll =
/// ±90°, whatever the arm does; its stops are before that, and its solution stays within them.
const Arm& six_motors_arm();

}  // namespace haptic

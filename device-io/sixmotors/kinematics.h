// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "device-io/woodenhaptics/kinematics.h"
#include "proto/math/pose.h"

namespace haptic {

/// Three motors that turn the handle in a gimbal, in the order of its axes from the forearm.
struct WristGeometry {
  std::array<double, 3> ratio{8, 8, 8};       // diameter of the pulley over that of the capstan
  std::array<double, 3> direction{1, -1, 1};  // sign of the joint's rotation per motor's
  std::array<int32_t, 3> home_counts{8192, 0, 0};  // added to counts that are zero at home
  double counts_per_turn = 4096;                   // per motor turn, with quadrature
  double torque_constant = 0.0138;                 // of a motor [N·m/A]
  double most_roll = 1.4;                          // the stops of the middle axis, ± [rad]
};

/// An arm of three joints that carries the handle in a wrist of three, whose axes meet in the
/// handle's origin: a device that does not exist yet, with a WoodenHaptics as its arm and guessed
/// motors in its wrist. All motors at home: upper arm upright, forearm level, handle as B.
struct SixMotorsGeometry {
  WoodenHapticsGeometry arm;
  WristGeometry wrist;
};

/// Joint angles (θ_A, β, γ; pitch, roll, yaw) [rad]. The wrist hangs on the forearm: pitch turns
/// about the axis of the elbow, roll about the axis that pitch carries, level where the handle is
/// upright, yaw about the handle's own z. With R(axis, angle) right-handed
///   q_BH = R(z, θ_A) R(y, ψ) R(x, roll) R(z, yaw),  ψ = pitch − γ,
/// so that a handle kept still turns the wrist against the arm. The wrist is singular at roll =
/// ±90°, whatever the arm does; its stops are before that.
JointAngles joint_angles(const SixMotorsGeometry& geometry, const MotorCounts& counts);
/// The inverse, quantised as by an encoder: rounded down to whole counts.
MotorCounts motor_counts(const SixMotorsGeometry& geometry, const JointAngles& angles);

Pose handle_pose(const SixMotorsGeometry& geometry, const JointAngles& angles);

/// Joint angles of a handle at X_BH, elbow up, |roll| ≤ most_roll; false, and `angles` stays, where
/// the arm does not reach or the wrist is at its stops.
bool solve_joint_angles(const SixMotorsGeometry& geometry, const Pose& X_BH, JointAngles& angles);

/// Column i: velocity of the handle's origin and angular velocity of the handle in B, per joint
/// velocity q̇_i.
std::array<Twist, 6> handle_jacobian(const SixMotorsGeometry& geometry, const JointAngles& angles);

/// Motor currents [A] for the wrench on the hand at the handle's origin: joint torques τ = Jᵀ F.
MotorAmperes motor_currents(const SixMotorsGeometry& geometry, const JointAngles& angles,
                            const Wrench& F_B);
/// The inverse, F = J⁻ᵀ τ: the wrist's torques give the torque on the hand; what of the arm's
/// torques does not hold against that is force. Zero where arm or wrist is singular.
Wrench handle_wrench(const SixMotorsGeometry& geometry, const JointAngles& angles,
                     const MotorAmperes& currents);

/// The device of these defaults.
const Arm& six_motors_arm();

}  // namespace haptic

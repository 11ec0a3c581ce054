// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "device-io/motors/arm.h"
#include "proto/math/mat3.h"
#include "proto/math/vec3.h"

namespace haptic {

/// A serial arm of three bodies, each driven by a capstan: A turns about the vertical, B is the
/// upper arm, C the forearm. The defaults are the WoodenHaptics of 2015, model 3 in its Teensy
/// firmware. Source: forsslund/hfabapi, configuration woodenhaptics_v2015.
struct WoodenHapticsGeometry {
  double shoulder_height = 0.080;              // of B's axis above the table [m]
  double upper_arm = 0.205;                    // [m]
  double forearm = 0.245;                      // [m]
  Vec3 origin{0.220, 0, 0.080};                // of frame B, from the foot of A's axis [m]
  std::array<double, 3> ratio{16, 12, 12};     // diameter of the body over that of the capstan
  std::array<double, 3> direction{1, -1, -1};  // sign of the body's rotation per encoder's
  std::array<double, 3> torque_direction{1, -1, -1};  // sign of the body's torque per current
  MotorCounts home_counts{0, 0, -6000};               // added to counts that are zero at home
  double counts_per_turn = 2000;                      // per motor turn, with quadrature
  double torque_constant = 0.0259;                    // of a motor [N·m/A]
};

/// Joint angles q = (θ_A, β, γ) [rad]: azimuth; upper arm from the vertical; forearm from the
/// vertical that points down. q_i = direction_i · 2π (n_i + home_i) / (counts_per_turn · ratio_i).
/// At home (n = 0) the upper arm stands upright and the forearm lies level: q = (0, 0, π/2).
Vec3 joint_angles(const WoodenHapticsGeometry& geometry, const MotorCounts& counts);

/// The inverse, quantised as by an encoder: rounded down to whole counts.
MotorCounts motor_counts(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles);

/// Tip of the forearm, in B: with ρ = upper_arm sin β + forearm sin γ,
///   (cos θ_A ρ, sin θ_A ρ, shoulder_height + upper_arm cos β − forearm cos γ) − origin.
Vec3 tip_position(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles);

/// Joint angles that put the tip at p_B, elbow up (0 < β + γ < π); false if it is out of reach or
/// straight above the shoulder.
bool solve_joint_angles(const WoodenHapticsGeometry& geometry, const Vec3& p_B, Vec3& joint_angles);

/// J with v_B = J q̇.
Mat3 tip_jacobian(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles);

/// Motor currents [A] for joint torques [N·m]: a motor's torque is direction_i τ_i / ratio_i,
/// divided by the torque constant. Friction and gravity are not compensated.
Vec3 currents_of_torques(const WoodenHapticsGeometry& geometry, const Vec3& torques);
/// The inverse.
Vec3 torques_of_currents(const WoodenHapticsGeometry& geometry, const Vec3& currents);

/// Motor currents [A] for the force F_B [N] of the tip on the hand: joint torques τ = Jᵀ F.
Vec3 motor_currents(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles,
                    const Vec3& F_B);

/// The force at the tip [N] of joint torques, F = J⁻ᵀ τ. Zero if the arm is stretched or folded,
/// which no workspace includes.
Vec3 force_of_torques(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles,
                      const Vec3& torques);

/// The force at the tip [N] of motor currents: that of the joint torques they make.
Vec3 tip_force(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles,
               const Vec3& currents);

/// The device of these defaults.
const Arm& woodenhaptics_arm();

}  // namespace haptic

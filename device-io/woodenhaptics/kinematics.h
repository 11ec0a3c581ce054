// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "proto/math/mat3.h"
#include "proto/math/vec3.h"

namespace haptic {

/// Encoder counts of the three motors; any origin and any sign.
using MotorCounts = std::array<int32_t, 3>;

/// A serial arm of three bodies, each driven by a capstan: A turns about the vertical, B is the
/// upper arm, C the forearm. The defaults are the WoodenHaptics of 2015, which its Teensy firmware
/// calls model 3. Source: forsslund/hfabapi, configuration woodenhaptics_v2015.
struct WoodenHapticsGeometry {
  double shoulder_height = 0.080;              // of B's axis above the table [m]
  double upper_arm = 0.205;                    // [m]
  double forearm = 0.245;                      // [m]
  Vec3 origin{0.220, 0, 0.080};                // of B, seen from the foot of A's axis [m]
  std::array<double, 3> ratio{16, 12, 12};     // diameter of the body over that of the capstan
  std::array<double, 3> direction{1, -1, -1};  // of the body where its motor turns forward
  MotorCounts home_counts{0, 0, -6000};        // added to counts that are zero at home
  double counts_per_turn = 2000;               // of a motor, quadrature included
  double torque_constant = 0.0259;             // of a motor [N·m/A]
};

/// Joint angles q = (θ_A, β, γ) [rad]: azimuth; upper arm from the vertical; forearm from the
/// vertical that points down. q_i = direction_i · 2π (n_i + home_i) / (counts_per_turn · ratio_i).
/// At home (n = 0) the upper arm stands upright and the forearm lies level: q = (0, 0, π/2).
Vec3 joint_angles(const WoodenHapticsGeometry& geometry, const MotorCounts& counts);

/// The inverse, as an encoder does it: the largest whole count that is not above the true one.
MotorCounts motor_counts(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles);

/// Tip of the forearm, in B: with ρ = upper_arm sin β + forearm sin γ,
///   (cos θ_A ρ, sin θ_A ρ, shoulder_height + upper_arm cos β − forearm cos γ) − origin.
Vec3 tip_position(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles);

/// Joint angles that bring the tip to p_B, elbow up (0 < β + γ < π); false where the arm is too
/// short or too long for it, or straight up.
bool solve_joint_angles(const WoodenHapticsGeometry& geometry, const Vec3& p_B, Vec3& joint_angles);

/// J with v_B = J q̇.
Mat3 tip_jacobian(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles);

/// Currents [A] of the motors with which the tip pushes the hand with F_B [N]: joint torques
/// τ = Jᵀ F, a motor's torque direction_i τ_i / ratio_i, divided by the torque constant. Friction
/// and gravity are not compensated.
Vec3 motor_currents(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles,
                    const Vec3& F_B);

/// The inverse: the force [N] at the tip, F = J⁻ᵀ τ. Zero where the arm is stretched or folded,
/// which no workspace contains.
Vec3 tip_force(const WoodenHapticsGeometry& geometry, const Vec3& joint_angles,
               const Vec3& currents);

}  // namespace haptic

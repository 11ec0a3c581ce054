// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "device-io/motors/arm.h"
#include "device-io/polhem/linkage.h"

namespace haptic {

/// A Polhem: three motors with encoders at its linkage, three encoders in the gimbal of its handle,
/// which has no motors. Source as of PolhemLinkage; the signs of the gimbal are those of getRot in
/// hfab_api.cpp.
struct PolhemGeometry {
  PolhemLinkage linkage;
  // of the body that a capstan drives, by the diameter of the capstan
  std::array<double, 3> ratio{0.175 / 0.0288534, 0.1 / 0.0136981, 0.1 / 0.0137281};
  std::array<double, 6> direction{1, -1, 1, -1, -1, 1};           // sign of the angle per encoder's
  std::array<double, 3> torque_constant{0.0603, 0.0538, 0.0538};  // of a motor [N·m/A]
  // where the firmware counts from: folded, its handle in its rest
  std::array<int32_t, 6> home_counts{8312, -10366, 19764, 0, 30, 0};
  double counts_per_turn = 4096;         // of a motor, with quadrature
  double gimbal_counts_per_turn = 1024;  // of an axis of the gimbal
};

/// Joint angles (A, B, C; D, E, F) [rad]: of the linkage; of the gimbal, which turns the handle
/// against the forearm about its x (along the forearm), y and x again:
///   q_BH = R(z, A) R(y, −λ) R(x, D) R(y, E) R(x, F).
JointAngles joint_angles(const PolhemGeometry& geometry, const MotorCounts& counts);
/// The inverse, quantised as by an encoder: rounded down to whole counts.
MotorCounts motor_counts(const PolhemGeometry& geometry, const JointAngles& angles);

Pose handle_pose(const PolhemGeometry& geometry, const JointAngles& angles);

/// Joint angles of a handle at X_BH, −π ≤ E ≤ 0; D is zero where the handle is in line with the
/// forearm. False, and `angles` stays, out of reach.
bool solve_joint_angles(const PolhemGeometry& geometry, const Pose& X_BH, JointAngles& angles);

/// Motor currents [A] for the force F_B of the handle on the hand: joint torques τ = Jᵀ F, of which
/// a motor has direction_i τ_i / ratio_i. Friction and gravity are not compensated. Zero where the
/// linkage is singular.
MotorAmperes motor_currents(const PolhemGeometry& geometry, const JointAngles& angles,
                            const Vec3& F_B);
/// The inverse, F = J⁻ᵀ τ.
Vec3 handle_force(const PolhemGeometry& geometry, const JointAngles& angles,
                  const MotorAmperes& currents);

/// The device of these defaults.
const Arm& polhem_arm();

}  // namespace haptic

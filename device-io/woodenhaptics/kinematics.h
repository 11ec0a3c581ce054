// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "device-io/motors/arm.h"
#include "proto/math/mat3.h"
#include "proto/math/vec3.h"

namespace haptic {

/// A serial arm of three bodies: A turns about the vertical, B is the upper arm, C the forearm. The
/// defaults are the WoodenHaptics of 2015, model 3 in its Teensy firmware. Source:
/// forsslund/hfabapi, configuration woodenhaptics_v2015.
///
/// Joint angles q = (θ_A, β, γ) [rad]: azimuth; upper arm from the vertical; forearm from the
/// vertical that points down.
struct WoodenHapticsGeometry {
  double shoulder_height = 0.080;  // of B's axis above the table [m]
  double upper_arm = 0.205;        // [m]
  double forearm = 0.245;          // [m]
  Vec3 origin{0.220, 0, 0.080};    // of frame B, from the foot of A's axis [m]
};

/// Tip of the forearm, in B: with ρ = upper_arm sin β + forearm sin γ,
///   (cos θ_A ρ, sin θ_A ρ, shoulder_height + upper_arm cos β − forearm cos γ) − origin.
Vec3 tip_position(const WoodenHapticsGeometry& geometry, const JointAngles& q);

/// Joint angles that put the tip at p_B, elbow up (0 < β + γ < π), in the first three of q; false,
/// and q stays, if it is out of reach or straight above the shoulder.
bool solve_tip(const WoodenHapticsGeometry& geometry, const Vec3& p_B, JointAngles& q);

/// J with v_B = J q̇.
Mat3 tip_jacobian(const WoodenHapticsGeometry& geometry, const JointAngles& q);

/// A body driven by a capstan: its diameter over that of the capstan, the signs of its rotation per
/// encoder's and of its torque per current.
struct DrivenBody {
  double ratio, direction, torque_direction;
  int32_t home = 0;
};

/// An axis for each body, by the counts of a turn of the motor, with quadrature, and the motor's
/// torque constant [N·m/A]:
///   q = direction · 2π (n + home)/(counts · ratio),  τ = torque_direction · ratio · constant · I.
Axis axis_of(const DrivenBody& body, double counts_per_turn, double torque_constant);

/// An arm with this geometry, that has neither axes nor a name yet. Its wrench is zero where it is
/// stretched or folded, which no workspace includes.
Arm serial_arm(const WoodenHapticsGeometry& geometry);

/// The device of the defaults. At home (n = 0) the upper arm stands upright and the forearm lies
/// level: q = (0, 0, π/2).
const Arm& woodenhaptics_arm();

}  // namespace haptic

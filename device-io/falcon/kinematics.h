// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>

#include "device-io/motors/arm.h"
#include "proto/math/mat3.h"
#include "proto/math/vec3.h"

namespace haptic {

/// A delta robot of three legs: a driven upper arm, a parallelogram, and offsets between them.
/// Lengths and azimuths are those of the Novint Falcon (reverse engineered; libnifalcon has the
/// same). Frame B: x right, y up, z along the device's axis to the user; its origin lies on the
/// axis, in the middle of the largest sphere that the handle can reach, of 50 mm.
struct FalconGeometry {
  double upper_arm = 0.060;       // a [m]
  double parallelogram = 0.1025;  // b [m]
  double plate_radius = 0.01443;  // c, of the handle's plate [m]
  double knee = 0.01125;          // d, along the leg [m]
  double ankle = 0.01125;         // e, along the leg [m]
  double plate_shift = -0.025;    // f, across the leg [m]
  double motor_radius = 0.040;    // r, of the motors' axes about the device's [m]
  double motor_shift = -0.02309;  // s, across the leg [m]
  double origin_z = 0.125;        // of frame B, from the plane of the motors [m]
  std::array<double, 3> azimuth{  // φ of the legs about z [rad]
                                1.83259571459404606, -0.26179938779914943, -2.35619449019234492};
  double home = 0.61086523819801535;  // angle of an upper arm at zero counts: 35° [rad]
  double angle_per_count =
      6.359047629780477e-4;  // 2π/1280 · 14.25 mm/110 mm, capstan and sector [rad]
};

/// Joint angles and their derivatives at a place of the handle.
struct FalconPose {
  Vec3 angles;                       // θ of the upper arms [rad]
  Mat3 J{{Vec3{}, Vec3{}, Vec3{}}};  // ∂θ/∂p, a row per leg [rad/m]
};

/// Solves the legs' constraint (P_u − a cos θ)² + (P_w − a sin θ)² = (d + e + √(b² − P_v²))² for
/// θ, with P the handle in the leg's plane. False, and `pose` is undefined: out of reach, or a leg
/// is stretched.
bool solve_falcon(const FalconGeometry& g, const Vec3& p_B, FalconPose& pose) noexcept;

/// Moves p_B to the place of the handle with these joint angles: Newton's method from p_B, in steps
/// of at most 20 mm, until the angles agree to 1e-12 rad. False, and p_B stays: not within 20
/// steps, or out of reach. From the place a millisecond ago it takes two steps.
bool find_falcon_handle(const FalconGeometry& g, const Vec3& angles, Vec3& p_B) noexcept;

/// First moment in B of the three upper arms and the three parallelograms at a place of the handle:
/// x along the upper arm, or along the rods from the knee on; y across the leg, for the rods as
/// nearly as they allow. Zero out of reach.
Vec3 falcon_moment(const FalconGeometry& g, const LinkMasses& links, const Vec3& p_B) noexcept;

/// Velocity of the handle per angular velocity of each upper arm, the columns of (∂θ/∂p)⁻¹ [m/rad].
/// False: the pose is singular.
bool falcon_jacobian(const FalconPose& pose, HandleJacobian& J) noexcept;

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/arm.h"
#include "proto/math/mat3.h"
#include "proto/math/vec3.h"

namespace haptic {

/// The arm of a Polhem of 2020, which its Teensy firmware calls model 1. All of it turns by A about
/// the vertical. In the plane that A turns, two links are driven by motors that stand `base` apart
/// on a level line, the vertical in their middle: the upper arm by B, on the far side, and a crank
/// by C. A rod goes from the crank to the tail of the forearm, behind the elbow, so that B and C
/// lift the forearm together. Source: forsslund/hfabapi (cf00e97), hfab_polhem.h and the
/// configuration polhem_v3 of hfab_math.h.
struct PolhemLinkage {
  double base = 0.034;             // between the motors of B and C [m]
  double upper_arm = 0.165;        // [m]
  double crank = 0.025;            // [m]
  double rod = 0.190;              // [m]
  double tail = 0.034;             // of the forearm, from the elbow to the rod [m]
  double forearm = 0.1308;         // from the elbow to the handle [m]
  Vec3 origin{0.2045, 0, 0.0325};  // of frame B, from the middle of the motors [m]
};

/// Angle λ of the forearm above the level [rad], with x the angles A, B and C of the driven links,
/// B and C above the level. The end of the tail is a distance `tail` from the elbow and `rod` from
/// the end of the crank: with d from the elbow to the crank's end,
///   λ = atan2(d) − π − acos((tail² + d² − rod²)/(2 tail d)).
/// Where rod and tail do not meet, as with counts that no arm has, they point at each other.
double forearm_angle(const PolhemLinkage& linkage, const Vec3& driven);

/// Handle, in B: with ρ = base/2 + upper_arm cos B + forearm cos λ,
///   (ρ cos A, ρ sin A, upper_arm sin B + forearm sin λ) − origin.
Vec3 handle_place(const PolhemLinkage& linkage, const Vec3& driven);

/// First moment in B of upper arm, forearm and crank, each with x along it from the joint that
/// carries it, y level, to the left of where the arm points. The rod is not among them.
Vec3 linkage_moment(const PolhemLinkage& linkage, const LinkMasses& links, const Vec3& driven);

/// Angles of the driven links of a handle at p_B, upper arm above the forearm; false, and `driven`
/// stays, out of reach.
bool solve_linkage(const PolhemLinkage& linkage, const Vec3& p_B, Vec3& driven);

/// J with v_B = J · (Ȧ, Ḃ, Ċ). False where rod and tail are in one line.
bool linkage_jacobian(const PolhemLinkage& linkage, const Vec3& driven, Mat3& J);

}  // namespace haptic

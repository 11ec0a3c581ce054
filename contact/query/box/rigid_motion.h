// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"

namespace haptic {

/// Interpolated motion of a body between two poses over time 0 to 1: its centre moves linearly, the
/// body rotates about it at constant speed along the shorter arc, R(t) = exp(t θ) R(0). Any
/// continuous rigid motion between the poses would do (Redon, Kheddar, Coquillart 2002); with the
/// centre of mass it resembles the motion of a free body.
struct RigidMotion {
  Quat q_OT;         // at t = 0
  Vec3 centre_O;     // at t = 0
  Vec3 way_O;        // displacement of the centre [m]
  Vec3 turn_O;       // θ, rotation vector [rad]
  Vec3 centre_T;     // centre of rotation
  double angle = 0;  // |θ| [rad]

  Pose at(double t) const;
};

RigidMotion motion_between(const Pose& from_OT, const Pose& to_OT, const Vec3& centre_T);

/// Part of a motion, with the poses at its ends.
struct MotionStretch {
  RigidMotion motion;
  double from = 0, to = 1;
  Pose from_OT, to_OT;
  double rounding = 0;  // error of a computed corner, at most [m]

  Pose at(double t) const { return t == from ? from_OT : t == to ? to_OT : motion.at(t); }
};

/// `reach`: bound of all coordinates of both shapes, each in its own frame [m].
MotionStretch stretch_of(const RigidMotion& motion, double from, double to, double reach);

/// Deviation of a point at this distance from the centre from the straight line between its places
/// at two times this far apart, at most [m]: r (θ Δt)²/8, limited to r for angles below 3 rad, else
/// 2 r.
double off_the_chord(const RigidMotion& motion, double distance, double time);

}  // namespace haptic

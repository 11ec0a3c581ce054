// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"

namespace haptic {

/// How a body goes from one pose to another in a time from 0 to 1: its centre straight, and about
/// it a turn of constant speed along the shorter arc, R(t) = exp(t θ) R(0). Any motion between two
/// poses that is continuous and rigid would do (Redon, Kheddar, Coquillart 2002); with the centre
/// of mass this one is near what a free body does.
struct RigidMotion {
  Quat q_OT;         // at first
  Vec3 centre_O;     // at first
  Vec3 way_O;        // of the centre
  Vec3 turn_O;       // θ, a rotation vector [rad]
  Vec3 centre_T;     // about which it turns
  double angle = 0;  // |θ| [rad]

  Pose at(double t) const;
};

RigidMotion motion_between(const Pose& from_OT, const Pose& to_OT, const Vec3& centre_T);

/// Part of a motion, as the queries along it want it.
struct MotionStretch {
  RigidMotion motion;
  double from = 0, to = 1;
  Pose from_OT, to_OT;
  double rounding = 0;  // how far a corner may be off where it is computed to be, at most [m]

  Pose at(double t) const { return t == from ? from_OT : t == to ? to_OT : motion.at(t); }
};

/// `reach` [m]: no coordinate of either shape, in its own frame, is larger.
MotionStretch stretch_of(const RigidMotion& motion, double from, double to, double reach);

/// How far a point at this distance from the centre is off the straight line between its places at
/// two times so far apart, at most: r (θ Δt)²/8, and never more than r for less than 3 rad, else 2
/// r [m].
double off_the_chord(const RigidMotion& motion, double distance, double time);

}  // namespace haptic

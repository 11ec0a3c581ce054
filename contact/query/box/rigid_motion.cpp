// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/box/rigid_motion.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {

Pose RigidMotion::at(double t) const {
  const Quat q = normalized(from_rotation_vector(t * turn_O) * q_OT);
  return {centre_O + t * way_O - rotate(q, centre_T), q};
}

RigidMotion motion_between(const Pose& from_OT, const Pose& to_OT, const Vec3& centre_T) {
  const Vec3 centre_O = from_OT * centre_T;
  const Vec3 turn_O = to_rotation_vector(to_OT.q * conjugate(from_OT.q));
  return {from_OT.q, centre_O, to_OT * centre_T - centre_O, turn_O, centre_T, norm(turn_O)};
}

MotionStretch stretch_of(const RigidMotion& motion, double from, double to, double reach) {
  HAPTIC_ASSERT(from <= to && reach >= 0);
  // about sixty roundings, each half an ulp of the largest number
  constexpr double kRoundings = 64 * 0x1p-53;
  const double largest =
      4 * reach + norm(motion.centre_O) + norm(motion.way_O) + norm(motion.centre_T);
  return {motion, from, to, motion.at(from), motion.at(to), kRoundings * largest};
}

double off_the_chord(const RigidMotion& motion, double distance, double time) {
  HAPTIC_ASSERT(!(distance < 0) && !(time < 0));
  const double angle = motion.angle * time;
  // an arc of half a turn or more deviates from its chord by up to its radius, or twice that
  return angle < 3 ? distance * std::min(angle * angle / 8, 1.0) : 2 * distance;
}

}  // namespace haptic

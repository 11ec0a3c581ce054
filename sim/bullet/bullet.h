// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <btBulletDynamicsCommon.h>

#include "proto/math/pose.h"

namespace haptic {

static_assert(sizeof(btScalar) == sizeof(double));

inline btVector3 to_bullet(const Vec3& a) {
  return {a.x, a.y, a.z};
}
inline btQuaternion to_bullet(const Quat& q) {
  return {q.x, q.y, q.z, q.w};
}
inline btTransform to_bullet(const Pose& X) {
  return btTransform(to_bullet(X.q), to_bullet(X.p));
}
inline Vec3 from_bullet(const btVector3& a) {
  return {a.x(), a.y(), a.z()};
}
inline Pose from_bullet(const btTransform& X) {
  const btQuaternion q = X.getRotation();
  return {from_bullet(X.getOrigin()), normalized(Quat{q.x(), q.y(), q.z(), q.w()})};
}

}  // namespace haptic

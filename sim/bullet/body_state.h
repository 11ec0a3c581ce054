// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/mat3.h"
#include "sim/bullet/bullet.h"

/// A body of Bullet by its centre of mass.
namespace haptic {

// what held and has no impulse goes on holding: a step may come before the hand's next frame
inline constexpr int kHeldSteps = 5;     // [steps]
inline constexpr double kSticks = 0.95;  // of the greatest friction: less does not slide

inline Pose pose_of(const btRigidBody& body) {
  return from_bullet(body.getCenterOfMassTransform());
}
inline Twist twist_of(const btRigidBody& body) {
  return {from_bullet(body.getLinearVelocity()), from_bullet(body.getAngularVelocity())};
}
inline void set_twist(btRigidBody& body, const Twist& V_W) {
  body.setLinearVelocity(to_bullet(V_W.v));
  body.setAngularVelocity(to_bullet(V_W.w));
}

/// About the centre of mass, in W [kg·m²]; zero of a body without mass.
inline Mat3 inertia_of(const btRigidBody& body) {
  const btMatrix3x3& R = body.getCenterOfMassTransform().getBasis();
  const Vec3 inverse_moments = from_bullet(body.getInvInertiaDiagLocal());
  Mat3 inertia{{{}, {}, {}}};
  for (int k = 0; k < 3; ++k) {
    if (inverse_moments[k] == 0) continue;
    const Vec3 axis = from_bullet(R.getColumn(k));
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) inertia.row[i][j] += axis[i] * axis[j] / inverse_moments[k];
    }
  }
  return inertia;
}

/// A twist's momentum: linear, and angular about the centre of mass.
inline Twist momentum_of(const btRigidBody& body, const Twist& V_W) {
  return {body.getMass() * V_W.v, inertia_of(body) * V_W.w};
}

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/math/quat.h"

namespace haptic {

/// X_AB: pose of frame B in frame A; maps coordinates in B to coordinates in A. Binary layout of
/// geometry_msgs/Pose.
struct Pose {
  Vec3 p;  // origin of B in A [m]
  Quat q;  // orientation of B in A

  constexpr bool operator==(const Pose&) const = default;
};

/// X_AC = X_AB * X_BC.
constexpr Pose operator*(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.p + rotate(X_AB.q, X_BC.p), X_AB.q * X_BC.q};
}
/// p_A = X_AB * p_B, for a point.
constexpr Vec3 operator*(const Pose& X_AB, const Vec3& p_B) {
  return X_AB.p + rotate(X_AB.q, p_B);
}
constexpr Pose inverse(const Pose& X_AB) {
  const Quat q_BA = conjugate(X_AB.q);
  return {-rotate(q_BA, X_AB.p), q_BA};
}
inline bool is_finite(const Pose& X) {
  return is_finite(X.p) && is_finite(X.q);
}

/// V_AB: velocity of the origin of B and angular velocity of B, both expressed in A. Binary layout
/// of geometry_msgs/Twist.
struct Twist {
  Vec3 v;  // [m/s]
  Vec3 w;  // [rad/s]

  constexpr bool operator==(const Twist&) const = default;
};

/// Velocity of the point at lever arm r from the twist's origin, same frame.
constexpr Vec3 velocity_at(const Twist& V, const Vec3& r) {
  return V.v + cross(V.w, r);
}

/// Pose after moving with constant twist V (both in the outer frame) for dt seconds.
inline Pose extrapolate(const Pose& X, const Twist& V, double dt) {
  return {X.p + dt * V.v, normalized(from_rotation_vector(dt * V.w) * X.q)};
}

/// F: force and torque about a stated point, expressed in a stated frame. Binary layout of
/// geometry_msgs/Wrench.
struct Wrench {
  Vec3 f;  // force [N]
  Vec3 t;  // torque [N·m]

  constexpr bool operator==(const Wrench&) const = default;
};

constexpr Wrench operator+(const Wrench& a, const Wrench& b) {
  return {a.f + b.f, a.t + b.t};
}
constexpr Wrench operator-(const Wrench& a) {
  return {-a.f, -a.t};
}
constexpr Wrench operator*(double s, const Wrench& a) {
  return {s * a.f, s * a.t};
}

/// The wrench about another point: from P to Q, r = p_P − p_Q.
constexpr Wrench shift(const Wrench& F, const Vec3& r) {
  return {F.f, F.t + cross(r, F.f)};
}
inline bool is_finite(const Twist& V) {
  return is_finite(V.v) && is_finite(V.w);
}
inline bool is_finite(const Wrench& F) {
  return is_finite(F.f) && is_finite(F.t);
}

}  // namespace haptic

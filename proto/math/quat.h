// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/math/assert.h"
#include "proto/math/mat3.h"

namespace haptic {

/// Unit quaternion, Hamilton product, ROS order x y z w. q and −q are the same rotation.
struct Quat {
  double x = 0, y = 0, z = 0, w = 1;

  constexpr Vec3 vector() const { return {x, y, z}; }
  constexpr bool operator==(const Quat&) const = default;
};

constexpr Quat operator*(const Quat& a, const Quat& b) {
  return {
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
constexpr Quat conjugate(const Quat& q) {
  return {-q.x, -q.y, -q.z, q.w};
}
constexpr double dot(const Quat& a, const Quat& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

/// q/|q|; the identity where |q| is zero or not finite.
inline Quat normalized(const Quat& q) {
  const double length = std::sqrt(dot(q, q));
  if (!(length > 0) || !std::isfinite(length)) return {};
  return {q.x / length, q.y / length, q.z / length, q.w / length};
}

/// True if a quaternion was normalised; as coarse as for a vector.
inline bool is_unit(const Quat& q) {
  return std::fabs(dot(q, q) - 1) < 1e-2;
}

/// Rotates a by the unit quaternion q.
constexpr Vec3 rotate(const Quat& q, const Vec3& a) {
  const Vec3 t = 2.0 * cross(q.vector(), a);
  return a + q.w * t + cross(q.vector(), t);
}

constexpr Mat3 to_matrix(const Quat& q) {
  return from_columns(rotate(q, {1, 0, 0}), rotate(q, {0, 1, 0}), rotate(q, {0, 0, 1}));
}

/// exp: the rotation by |r| about r [rad].
inline Quat from_rotation_vector(const Vec3& r) {
  const double angle = norm(r);
  // the series 1/2 − a²/48 of sin(a/2)/a is exact to double below 1e-4
  const double s = angle > 1e-4 ? std::sin(angle / 2) / angle : 0.5 - angle * angle / 48;
  return {s * r.x, s * r.y, s * r.z, std::cos(angle / 2)};
}

/// log along the shorter arc: angle in [0, π] [rad].
inline Vec3 to_rotation_vector(const Quat& q) {
  const double sign = q.w < 0 ? -1 : 1;
  const double sine = norm(q.vector());
  if (sine < 1e-8) return 2 * sign * q.vector();
  return (2 * sign * std::atan2(sine, sign * q.w) / sine) * q.vector();
}

/// Constant-speed interpolation along the shorter arc; t in [0, 1].
inline Quat slerp(const Quat& a, const Quat& b, double t) {
  HAPTIC_ASSERT(t >= 0 && t <= 1);
  return a * from_rotation_vector(t * to_rotation_vector(conjugate(a) * b));
}

inline bool is_finite(const Quat& q) {
  return is_finite(q.vector()) && std::isfinite(q.w);
}

}  // namespace haptic

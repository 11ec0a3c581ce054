// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <span>

#include "proto/math/assert.h"
#include "proto/math/spatial.h"

namespace haptic {

constexpr Twist operator+(const Twist& a, const Twist& b) {
  return {a.v + b.v, a.w + b.w};
}
constexpr Twist operator-(const Twist& a, const Twist& b) {
  return {a.v - b.v, a.w - b.w};
}
constexpr Twist operator*(double s, const Twist& a) {
  return {s * a.v, s * a.w};
}

/// The motion from one pose to another: moved(from, way_between(from, to)) is `to`.
inline Twist way_between(const Pose& from, const Pose& to) {
  return {to.p - from.p, to_rotation_vector(to.q * conjugate(from.q))};
}

/// The pose after a small motion.
inline Pose moved(const Pose& X, const Twist& motion) {
  return extrapolate(X, motion, 1);
}

/// Bound of the motion of any point of a body of that radius about the reference point: |v| + r |ω|
/// [m].
inline double largest_travel(const Twist& motion, double radius) {
  return norm(motion.v) + radius * norm(motion.w);
}

/// One inequality on a small motion or a twist a: J·a ≥ b. All rows and the motion refer to one
/// frame and point.
struct MotionRow {
  Twist J;
  double b = 0;
};

/// The row of a contact at lever arm r, unit normal n away from the obstacle: J = (n, r × n), so
/// J·a is the motion of the contact point out of the obstacle. b = min(−gap, most_push): a gap may
/// close; an overlap, gap < 0, is pushed out by at most most_push ≥ 0 per motion. For a twist
/// divide both by the time step.
constexpr MotionRow contact_row(const Vec3& r, const Vec3& normal, double gap, double most_push) {
  HAPTIC_ASSERT(most_push >= 0);
  return {{normal, cross(r, normal)}, -gap < most_push ? -gap : most_push};
}

/// A metric of motions |a|² = aᵀ M a, such as a body's mass and inertia, factored once: M = L Lᵀ.
/// In the coordinates y = Lᵀ a it is the identity. L⁻¹ is kept too: multiplying by it has no chain
/// of dependent divisions, and makes a special case for diagonal M useless.
struct MotionMetric {
  Mat6 L, inverse_L;   // lower triangular
  bool valid = false;  // M was symmetric positive definite (to 1e-14 of its diagonal) and finite
};

/// Factors M; reads its lower half only.
MotionMetric factor_metric(const Mat6& M);

/// Mass m I about the centre of mass, and the inertia about it.
constexpr Mat6 mass_matrix(double mass, const Mat3& inertia) {
  Mat6 M;
  add_block(M, 0, 0, mass * Mat3{});
  add_block(M, 3, 3, inertia);
  return M;
}

/// diag(k_T, k_R): springs of translation [N/m] and rotation [N·m/rad].
constexpr Mat6 spring_matrix(double translational, double rotational) {
  Mat6 K;
  add_block(K, 0, 0, translational * Mat3{});
  add_block(K, 3, 3, rotational * Mat3{});
  return K;
}

/// Length of a motion in these springs, as a translation: √(|v|² + k_R/k_T |ω|²) [m].
inline double spring_length(const Twist& a, double translational, double rotational) {
  HAPTIC_ASSERT(!(translational <= 0));
  return std::sqrt(norm_squared(a.v) + rotational * norm_squared(a.w) / translational);
}

/// Size of a wrench in these springs, as a force: √(|f|² + k_T/k_R |τ|²), k_T times the length of
/// the motion that causes it [N].
inline double spring_force(const Wrench& F, double translational, double rotational) {
  return std::sqrt(norm_squared(F.f) + translational * norm_squared(F.t) / rotational);
}

using Vec6 = std::array<double, 6>;

constexpr double dot(const Vec6& a, const Vec6& b) {
  return (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

/// a += s b.
constexpr void add_scaled(Vec6& a, double s, const Vec6& b) {
  for (size_t i = 0; i < 6; ++i) a[i] += s * b[i];
}

/// L⁻¹ x: a Jacobian row or a wrench in the coordinates y.
Vec6 whitened(const MotionMetric& metric, const Vec6& x);

/// y = Lᵀ a: the coordinates of a motion.
Vec6 coordinates(const MotionMetric& metric, const Twist& a);

/// L⁻ᵀ y: the motion with these coordinates.
Twist motion_of(const MotionMetric& metric, const Vec6& y);

/// M⁻¹ F: acceleration by a wrench, change of twist by an impulse.
Twist response(const MotionMetric& metric, const Wrench& F);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/joint/pivot.h"

#include <Eigen/LU>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMostIterations = 16;   // w dt of 0.1 gains a digit in each
constexpr double kConverged = 1e-15;  // of the way of a step [rad]

/// The rotation about θ by 2 atan(|θ|/2).
Quat cayley(const Vec3& theta) {
  return normalized(Quat{0.5 * theta.x, 0.5 * theta.y, 0.5 * theta.z, 1});
}

}  // namespace

PivotBody build_pivot(double mass, const Vec3& moments, const Vec3& arm_C) {
  HAPTIC_ASSERT(mass > 0);
  PivotBody body{mass, arm_C, {}, {}};
  Eigen::Matrix3d inertia;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      // Steiner's: m (r² 1 − r rᵀ)
      inertia(i, k) = -mass * arm_C[i] * arm_C[k];
      if (i == k) inertia(i, k) += moments[i] + mass * norm_squared(arm_C);
    }
  }
  const Eigen::Matrix3d inverse = inertia.inverse();
  for (int i = 0; i < 3; ++i) {
    body.inertia_C.row[i] = {inertia(i, 0), inertia(i, 1), inertia(i, 2)};
    body.per_inertia_C.row[i] = {inverse(i, 0), inverse(i, 1), inverse(i, 2)};
  }
  return body;
}

Vec3 spin_of(const PivotBody& body, const Pivoting& at) {
  return rotate(at.q_WC, body.per_inertia_C * rotate(conjugate(at.q_WC), at.momentum_W));
}

Pivoting swung(const PivotBody& body, const Pivoting& now, const Vec3& gravity_W, double dt) {
  const Vec3 spin_C = body.per_inertia_C * rotate(conjugate(now.q_WC), now.momentum_W);
  const Vec3 arm_W = rotate(now.q_WC, body.arm_C);
  Vec3 turn_C = dt * spin_C;
  Pivoting next = now;
  for (int i = 0; i < kMostIterations; ++i) {
    next.q_WC = normalized(now.q_WC * cayley(turn_C));
    const Vec3 mean_arm_W = 0.5 * (arm_W + rotate(next.q_WC, body.arm_C));
    next.momentum_W = now.momentum_W + dt * cross(mean_arm_W, body.mass * gravity_W);
    const Vec3 next_C = body.per_inertia_C * rotate(conjugate(next.q_WC), next.momentum_W);
    const Vec3 last = turn_C;
    turn_C = 0.5 * dt * (spin_C + next_C);
    if (norm(turn_C - last) <= kConverged) break;
  }
  return next;
}

}  // namespace haptic

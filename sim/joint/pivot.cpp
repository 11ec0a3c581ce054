// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/joint/pivot.h"

#include <Eigen/LU>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMostIterations = 10;  // three or four below a tenth of a radian
constexpr double kConverged =
    1e-12;                        // of the turn of a step; a rod's long axis rounds by 1e-13 [rad]
constexpr double kDiverged = 10;  // [rad]
constexpr double kAside = 1e-6;   // of a difference quotient [rad]

/// The rotation about θ by 2 atan(|θ|/2).
Quat cayley(const Vec3& theta) {
  return normalized(Quat{0.5 * theta.x, 0.5 * theta.y, 0.5 * theta.z, 1});
}

}  // namespace

PivotBody build_pivot(double mass, const Vec3& moments, const Vec3& arm_C) {
  HAPTIC_ASSERT(mass > 0);
  PivotBody body{mass, arm_C, {}};
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
    body.per_inertia_C.row[i] = {inverse(i, 0), inverse(i, 1), inverse(i, 2)};
  }
  return body;
}

Vec3 spin_of(const PivotBody& body, const Pivoting& at) {
  return rotate(at.q_WC, body.per_inertia_C * rotate(conjugate(at.q_WC), at.momentum_W));
}

std::optional<Pivoting> swung(const PivotBody& body, const Pivoting& now, const Vec3& gravity_W,
                              double dt) {
  const Vec3 spin_C = body.per_inertia_C * rotate(conjugate(now.q_WC), now.momentum_W);
  const Vec3 arm_W = rotate(now.q_WC, body.arm_C);
  const auto after = [&](const Vec3& turn_C) {
    const Quat q_WC = normalized(now.q_WC * cayley(turn_C));
    const Vec3 mean_arm_W = 0.5 * (arm_W + rotate(q_WC, body.arm_C));
    return Pivoting{q_WC, now.momentum_W + dt * cross(mean_arm_W, body.mass * gravity_W)};
  };
  // by which a turn is more than the mean spin says
  const auto open = [&](const Vec3& turn_C) {
    const Pivoting next = after(turn_C);
    const Vec3 next_C = body.per_inertia_C * rotate(conjugate(next.q_WC), next.momentum_W);
    const Vec3 off = turn_C - 0.5 * dt * (spin_C + next_C);
    return Eigen::Vector3d(off.x, off.y, off.z);
  };
  Vec3 turn_C = dt * spin_C;
  for (int i = 0; i < kMostIterations; ++i) {
    const Eigen::Vector3d off = open(turn_C);
    if (!(off.norm() < kDiverged)) return std::nullopt;
    if (off.norm() <= kConverged) return after(turn_C);
    Eigen::Matrix3d slope;
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis{k == 0 ? kAside : 0, k == 1 ? kAside : 0, k == 2 ? kAside : 0};
      slope.col(k) = (open(turn_C + axis) - off) / kAside;
    }
    const Eigen::Vector3d step = slope.partialPivLu().solve(off);
    turn_C += Vec3{-step.x(), -step.y(), -step.z()};
  }
  return std::nullopt;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/arm.h"

#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

/// Cosine of how far the middle axis of a wrist may have turned from square.
constexpr double kLeastWrist = 1e-3;

}  // namespace

double angle_of_count(double direction, double counts, double ratio) {
  HAPTIC_ASSERT(counts > 0 && ratio > 0);
  return direction * 2 * kPi / (counts * ratio);
}

bool solve_rows(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& t, double least, Vec3& x) {
  const double volume = dot(a, cross(b, c));
  if (!(std::fabs(volume) >= least)) return false;
  x = (t.x * cross(b, c) + t.y * cross(c, a) + t.z * cross(a, b)) / volume;
  return true;
}

std::array<double, kMostMotors> Arm::most_accelerations() const {
  std::array<double, kMostMotors> most;
  for (size_t i = 0; i < most.size(); ++i) most[i] = axes[i].most_acceleration;
  return most;
}

JointAngles Arm::angles(const MotorCounts& n) const {
  JointAngles q{};
  for (size_t i = 0; i < encoders; ++i) {
    q[i] = axes[i].zero + axes[i].angle * (static_cast<double>(n[i]) + axes[i].home);
  }
  return q;
}

MotorCounts Arm::counts(const JointAngles& q) const {
  MotorCounts n{};
  for (size_t i = 0; i < encoders; ++i) {
    const double exact = std::floor((q[i] - axes[i].zero) / axes[i].angle);
    n[i] = static_cast<int32_t>(exact) - axes[i].home;
  }
  return n;
}

Pose Arm::pose(const JointAngles& q) const {
  Pose X_BH;
  find(q, X_BH);
  return X_BH;
}

bool Arm::efforts(const JointAngles& q, const Pose& X_BH, const Wrench& F_B,
                  MotorEfforts& out) const {
  out = {};
  HandleJacobian J{};
  if (!jacobian(q, X_BH, J)) return false;
  for (size_t i = 0; i < motors; ++i) {
    out[i] = (dot(J[i].v, F_B.f) + dot(J[i].w, F_B.t)) / axes[i].torque;
  }
  return true;
}

Wrench Arm::wrench(const JointAngles& q, const MotorEfforts& efforts) const {
  HandleJacobian J{};
  if (!jacobian(q, pose(q), J)) return {};
  std::array<double, kMostMotors> torque{};
  for (size_t i = 0; i < motors; ++i) torque[i] = axes[i].torque * efforts[i];
  return wrench_of(J, torque);
}

Wrench Arm::wrench_of(HandleJacobian J, std::array<double, kMostMotors> torque) const {
  if (motors == 2) J[2].v = {0, 0, 1};
  Wrench F_B;
  if (max_torque > 0) {
    const Vec3 wrist{torque[3], torque[4], torque[5]};
    if (!solve_rows(J[3].w, J[4].w, J[5].w, wrist, kLeastWrist, F_B.t)) return {};
    for (size_t i = 0; i < 3; ++i) torque[i] -= dot(J[i].w, F_B.t);
  }
  solve_rows(J[0].v, J[1].v, J[2].v, {torque[0], torque[1], torque[2]}, least_volume, F_B.f);
  return F_B;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/holding.h"

namespace haptic {
namespace {

constexpr double kGravity = 9.81;  // [m/s²]; from equator to pole it is within 0.3 %
constexpr double kStep = 1e-4;     // of a joint [rad]

/// First moment of handle and links in B [kg·m].
Vec3 moment(const Arm& arm, const GravityConfig& gravity, const JointAngles& q, const Pose& X_BH) {
  const Vec3 centre_H = arm.max_torque > 0 ? gravity.handle.centre : Vec3{};
  const Vec3 of_handle = gravity.handle.mass * (X_BH * centre_H);
  return arm.links ? of_handle + arm.links(gravity.links, q, X_BH) : of_handle;
}

}  // namespace

Wrench holding_wrench(const Arm& arm, const GravityConfig& gravity, const JointAngles& q,
                      const Pose& X_BH) {
  HandleJacobian J{};
  if (!arm.jacobian(q, X_BH, J)) return {};
  const Vec3 down_B = gravity.down_B != Vec3{} ? gravity.down_B : arm.down_B;
  const auto energy = [&](size_t joint, double step) {
    JointAngles moved = q;
    moved[joint] += step;
    const Quat turn = from_rotation_vector(step * J[joint].w);
    return -kGravity *
           dot(down_B, moment(arm, gravity, moved, {X_BH.p + step * J[joint].v, turn * X_BH.q}));
  };
  std::array<double, kMostMotors> torques{};
  for (size_t i = 0; i < arm.motors; ++i) {
    torques[i] = (energy(i, kStep) - energy(i, -kStep)) / (2 * kStep);
  }
  return arm.wrench_of(J, torques);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/sixmotors/kinematics.h"

#include <cmath>
#include <numbers>

#include "device-io/sensing/encoder_noise.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr SixMotorsGeometry kGeometry;
constexpr double kSingular = 1e-3;  // of the cosine of roll

Vec3 arm_of(const std::array<double, kMostMotors>& a) {
  return {a[0], a[1], a[2]};
}
Vec3 wrist_of(const std::array<double, kMostMotors>& a) {
  return {a[3], a[4], a[5]};
}
std::array<double, kMostMotors> joined(const Vec3& arm, const Vec3& wrist) {
  return {arm.x, arm.y, arm.z, wrist.x, wrist.y, wrist.z};
}

/// Joint angle per count of the wrist's motor [rad].
double angle_of_count(const WristGeometry& g, size_t k) {
  HAPTIC_ASSERT(k < 3 && g.counts_per_turn > 0);
  return g.direction[k] * 2 * std::numbers::pi / (g.counts_per_turn * g.ratio[k]);
}

/// Joint torque per current of the wrist's motor [N·m/A].
double torque_of_current(const WristGeometry& g, size_t k) {
  HAPTIC_ASSERT(k < 3 && g.torque_constant > 0);
  return g.direction[k] * g.ratio[k] * g.torque_constant;
}

Quat turn_about(const Vec3& axis, double angle) {
  return from_rotation_vector(angle * axis);
}

/// The directions in B about which the joints turn the handle.
struct TurningAxes {
  Vec3 azimuth, elbow, pitch, roll, yaw;
};

TurningAxes axes_at(const JointAngles& q) {
  const Quat azimuth = turn_about({0, 0, 1}, q[0]);
  const Quat pitched = azimuth * turn_about({0, 1, 0}, q[3] - q[2]);
  const Vec3 level = rotate(azimuth, {0, 1, 0});
  return {{0, 0, 1},
          -level,
          level,
          rotate(pitched, {1, 0, 0}),
          rotate(pitched * turn_about({1, 0, 0}, q[4]), {0, 0, 1})};
}

}  // namespace

JointAngles joint_angles(const SixMotorsGeometry& g, const MotorCounts& counts) {
  JointAngles q = joined(joint_angles(g.arm, counts), {});
  for (size_t k = 0; k < 3; ++k) {
    q[3 + k] =
        angle_of_count(g.wrist, k) * (static_cast<double>(counts[3 + k]) + g.wrist.home_counts[k]);
  }
  return q;
}

MotorCounts motor_counts(const SixMotorsGeometry& g, const JointAngles& q) {
  MotorCounts counts = motor_counts(g.arm, arm_of(q));
  for (size_t k = 0; k < 3; ++k) {
    const double exact = std::floor(q[3 + k] / angle_of_count(g.wrist, k));
    counts[3 + k] = static_cast<int32_t>(exact) - g.wrist.home_counts[k];
  }
  return counts;
}

Pose handle_pose(const SixMotorsGeometry& g, const JointAngles& q) {
  const Quat turned = turn_about({0, 0, 1}, q[0]) * turn_about({0, 1, 0}, q[3] - q[2]) *
                      turn_about({1, 0, 0}, q[4]) * turn_about({0, 0, 1}, q[5]);
  return {tip_position(g.arm, arm_of(q)), normalized(turned)};
}

bool solve_joint_angles(const SixMotorsGeometry& g, const Pose& X_BH, JointAngles& angles) {
  Vec3 arm;
  if (!solve_joint_angles(g.arm, X_BH.p, arm)) return false;
  // what is left of the orientation, R(y, ψ) R(x, roll) R(z, yaw), by its entries
  const Mat3 rest = to_matrix(turn_about({0, 0, 1}, -arm.x) * X_BH.q);
  const double roll = std::asin(std::fmin(std::fmax(-rest.row[1].z, -1), 1));
  if (!(std::fabs(roll) <= g.wrist.most_roll)) return false;
  const double upright = std::atan2(rest.row[0].z, rest.row[2].z);
  const double yaw = std::atan2(rest.row[1].x, rest.row[1].y);
  angles = joined(arm, {upright + arm.z, roll, yaw});
  return true;
}

std::array<Twist, 6> handle_jacobian(const SixMotorsGeometry& g, const JointAngles& q) {
  const Mat3 tip = tip_jacobian(g.arm, arm_of(q));
  const TurningAxes axes = axes_at(q);
  return {{{tip.column(0), axes.azimuth},
           {tip.column(1), {}},  // a parallel linkage: the upper arm leaves the forearm's direction
           {tip.column(2), axes.elbow},
           {{}, axes.pitch},
           {{}, axes.roll},
           {{}, axes.yaw}}};
}

MotorAmperes motor_currents(const SixMotorsGeometry& g, const JointAngles& q, const Wrench& F_B) {
  const auto J = handle_jacobian(g, q);
  std::array<double, kMostMotors> torque{};
  for (size_t i = 0; i < torque.size(); ++i) torque[i] = dot(J[i].v, F_B.f) + dot(J[i].w, F_B.t);
  Vec3 wrist;
  for (size_t k = 0; k < 3; ++k) {
    wrist[static_cast<int>(k)] = torque[3 + k] / torque_of_current(g.wrist, k);
  }
  return joined(currents_of_torques(g.arm, arm_of(torque)), wrist);
}

Wrench handle_wrench(const SixMotorsGeometry& g, const JointAngles& q,
                     const MotorAmperes& currents) {
  const TurningAxes axes = axes_at(q);
  const Vec3 a = axes.pitch, b = axes.roll, c = axes.yaw;
  const double determinant = dot(a, cross(b, c));  // −cos roll
  if (std::fabs(determinant) < kSingular) return {};
  Vec3 wrist = wrist_of(currents);
  for (size_t k = 0; k < 3; ++k) wrist[static_cast<int>(k)] *= torque_of_current(g.wrist, k);
  // Cramer's rule: τ_i = axis_i · t
  const Vec3 t =
      (wrist.x * cross(b, c) + wrist.y * cross(c, a) + wrist.z * cross(a, b)) / determinant;
  const Vec3 arm = torques_of_currents(g.arm, arm_of(currents));
  const Vec3 held{dot(axes.azimuth, t), 0, dot(axes.elbow, t)};
  return {force_of_torques(g.arm, arm_of(q), arm - held), t};
}

const Arm& six_motors_arm() {
  // of the wrist: 3000 rad/s², by 5215 counts a radian. Its motors turn a bare handle of 1e-4 kg·m²
  // no faster; an arm that throws turns it by 500
  constexpr double kWristAcceleration = 1.6e-11;
  static constexpr Arm kArm{
      .name = "device with six motors",
      .model = 6,
      .motors = 6,
      .encoders = 6,
      .max_force = 5,
      .max_torque = 0.3,
      .most_acceleration = {kTipAcceleration, kTipAcceleration, kTipAcceleration,
                            kWristAcceleration, kWristAcceleration, kWristAcceleration},
      .angles = [](const MotorCounts& n) { return joint_angles(kGeometry, n); },
      .counts = [](const JointAngles& q) { return motor_counts(kGeometry, q); },
      .pose = [](const JointAngles& q) { return handle_pose(kGeometry, q); },
      .solve = [](const Pose& X_BH,
                  JointAngles& q) { return solve_joint_angles(kGeometry, X_BH, q); },
      .currents = [](const JointAngles& q,
                     const Wrench& F_B) { return motor_currents(kGeometry, q, F_B); },
      .wrench = [](const JointAngles& q,
                   const MotorAmperes& currents) { return handle_wrench(kGeometry, q, currents); },
  };
  return kArm;
}

}  // namespace haptic

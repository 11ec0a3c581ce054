// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/kinematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "device-io/sensing/encoder_noise.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kSingular = 1e-3;  // of the determinant at a right-angled elbow: nearly straight

constexpr WoodenHapticsGeometry kGeometry;

Vec3 three_of(const std::array<double, kMostMotors>& a) {
  return {a[0], a[1], a[2]};
}
std::array<double, kMostMotors> six_of(const Vec3& a) {
  return {a.x, a.y, a.z, 0, 0, 0};
}

/// Joint angle per count of the motor [rad].
double angle_of_count(const WoodenHapticsGeometry& g, int i) {
  HAPTIC_ASSERT(i >= 0 && i < 3 && g.counts_per_turn > 0);
  const size_t k = static_cast<size_t>(i);
  return g.direction[k] * 2 * std::numbers::pi / (g.counts_per_turn * g.ratio[k]);
}

/// Distance of the tip from A's axis [m].
double reach(const WoodenHapticsGeometry& g, const Vec3& q) {
  return g.upper_arm * std::sin(q.y) + g.forearm * std::sin(q.z);
}

/// Joint torque per motor current [N·m/A].
double torque_of_current(const WoodenHapticsGeometry& g, int i) {
  HAPTIC_ASSERT(i >= 0 && i < 3 && g.torque_constant > 0);
  const size_t k = static_cast<size_t>(i);
  return g.torque_direction[k] * g.ratio[k] * g.torque_constant;
}

}  // namespace

Vec3 joint_angles(const WoodenHapticsGeometry& g, const MotorCounts& counts) {
  Vec3 q;
  for (int i = 0; i < 3; ++i) {
    const size_t k = static_cast<size_t>(i);
    q[i] = angle_of_count(g, i) * (static_cast<double>(counts[k]) + g.home_counts[k]);
  }
  return q;
}

MotorCounts motor_counts(const WoodenHapticsGeometry& g, const Vec3& q) {
  MotorCounts counts{};
  for (int i = 0; i < 3; ++i) {
    const size_t k = static_cast<size_t>(i);
    counts[k] = static_cast<int32_t>(std::floor(q[i] / angle_of_count(g, i))) - g.home_counts[k];
  }
  return counts;
}

Vec3 tip_position(const WoodenHapticsGeometry& g, const Vec3& q) {
  const double rho = reach(g, q);
  const Vec3 tip{std::cos(q.x) * rho, std::sin(q.x) * rho,
                 g.shoulder_height + g.upper_arm * std::cos(q.y) - g.forearm * std::cos(q.z)};
  return tip - g.origin;
}

bool solve_joint_angles(const WoodenHapticsGeometry& g, const Vec3& p_B, Vec3& q) {
  HAPTIC_ASSERT(g.upper_arm > 0 && g.forearm > 0);
  const Vec3 tip = p_B + g.origin;
  const double rho = std::hypot(tip.x, tip.y);
  const double height = tip.z - g.shoulder_height;
  const double distance = std::hypot(rho, height);
  // triangle of shoulder, elbow and tip: its angles at elbow and shoulder
  const double b = g.upper_arm, c = g.forearm;
  const double cos_elbow = (b * b + c * c - distance * distance) / (2 * b * c);
  const double cos_shoulder = (b * b + distance * distance - c * c) / (2 * b * distance);
  if (!(std::fabs(cos_elbow) < 1 && std::fabs(cos_shoulder) <= 1 && rho > 0)) return false;
  const double beta = std::atan2(rho, height) - std::acos(cos_shoulder);
  q = {std::atan2(tip.y, tip.x), beta, std::acos(cos_elbow) - beta};
  return true;
}

Mat3 tip_jacobian(const WoodenHapticsGeometry& g, const Vec3& q) {
  const double rho = reach(g, q), b = g.upper_arm, c = g.forearm;
  const double sin_a = std::sin(q.x), cos_a = std::cos(q.x);
  return from_columns({-sin_a * rho, cos_a * rho, 0},
                      {b * cos_a * std::cos(q.y), b * sin_a * std::cos(q.y), -b * std::sin(q.y)},
                      {c * cos_a * std::cos(q.z), c * sin_a * std::cos(q.z), c * std::sin(q.z)});
}

Vec3 currents_of_torques(const WoodenHapticsGeometry& g, const Vec3& torques) {
  Vec3 currents;
  for (int i = 0; i < 3; ++i) currents[i] = torques[i] / torque_of_current(g, i);
  return currents;
}

Vec3 torques_of_currents(const WoodenHapticsGeometry& g, const Vec3& currents) {
  Vec3 torques;
  for (int i = 0; i < 3; ++i) torques[i] = torque_of_current(g, i) * currents[i];
  return torques;
}

Vec3 motor_currents(const WoodenHapticsGeometry& g, const Vec3& q, const Vec3& F_B) {
  return currents_of_torques(g, transpose(tip_jacobian(g, q)) * F_B);
}

Vec3 force_of_torques(const WoodenHapticsGeometry& g, const Vec3& q, const Vec3& torques) {
  const Mat3 J = tip_jacobian(g, q);
  const Vec3 a = J.column(0), b = J.column(1), c = J.column(2);
  // Cramer's rule: τ_i = column_i · F
  const double determinant = dot(a, cross(b, c));
  if (std::fabs(determinant) < kSingular * g.upper_arm * g.forearm * g.forearm) return {};
  return (torques.x * cross(b, c) + torques.y * cross(c, a) + torques.z * cross(a, b)) /
         determinant;
}

Vec3 tip_force(const WoodenHapticsGeometry& g, const Vec3& q, const Vec3& currents) {
  return force_of_torques(g, q, torques_of_currents(g, currents));
}

const Arm& woodenhaptics_arm() {
  static constexpr Arm kArm{
      .name = "WoodenHaptics",
      .model = 3,
      .motors = 3,
      .encoders = 3,
      .buttons = 1,  // of a firmware that reports one in the handle (protocol.h)
      .max_force = 5,
      .max_torque = 0,
      .most_acceleration = {kTipAcceleration, kTipAcceleration, kTipAcceleration},
      .angles = [](const MotorCounts& n) { return six_of(joint_angles(kGeometry, n)); },
      .counts = [](const JointAngles& q) { return motor_counts(kGeometry, three_of(q)); },
      .pose =
          [](const JointAngles& q) {
            return Pose{tip_position(kGeometry, three_of(q)), {}};
          },
      .solve =
          [](const Pose& X_BH, JointAngles& q) {
            Vec3 angles;
            if (!solve_joint_angles(kGeometry, X_BH.p, angles)) return false;
            q = six_of(angles);
            return true;
          },
      .currents =
          [](const JointAngles& q, const Wrench& F_B) {
            return six_of(motor_currents(kGeometry, three_of(q), F_B.f));
          },
      .wrench =
          [](const JointAngles& q, const MotorAmperes& currents) {
            return Wrench{tip_force(kGeometry, three_of(q), three_of(currents)), {}};
          },
  };
  return kArm;
}

}  // namespace haptic

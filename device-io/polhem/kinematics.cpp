// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/polhem/kinematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "device-io/sensing/encoder_noise.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr PolhemGeometry kGeometry;
constexpr double kSingular = 0.01;  // of the Jacobian's determinant, by the lengths of the links
constexpr double kInLine = 1e-9;    // sine of E

/// Joint angle per count [rad].
double angle_of_count(const PolhemGeometry& g, size_t k) {
  const double turn = g.direction[k] * 2 * std::numbers::pi;
  return k < 3 ? turn / (g.counts_per_turn * g.ratio[k]) : turn / g.gimbal_counts_per_turn;
}

/// Joint torque per current of the motor [N·m/A].
double torque_of_current(const PolhemGeometry& g, size_t k) {
  return g.direction[k] * g.ratio[k] * g.torque_constant[k];
}

Vec3 driven_of(const JointAngles& angles) {
  return {angles[0], angles[1], angles[2]};
}

Quat turn_about(const Vec3& axis, double angle) {
  return from_rotation_vector(angle * axis);
}

/// Of the forearm in B.
Quat forearm_turn(const PolhemGeometry& g, const Vec3& driven) {
  return turn_about({0, 0, 1}, driven.x) * turn_about({0, 1, 0}, -forearm_angle(g.linkage, driven));
}

}  // namespace

JointAngles joint_angles(const PolhemGeometry& g, const MotorCounts& counts) {
  JointAngles angles{};
  for (size_t k = 0; k < angles.size(); ++k) {
    angles[k] = angle_of_count(g, k) * (static_cast<double>(counts[k]) + g.home_counts[k]);
  }
  return angles;
}

MotorCounts motor_counts(const PolhemGeometry& g, const JointAngles& angles) {
  MotorCounts counts{};
  for (size_t k = 0; k < counts.size(); ++k) {
    const double exact = std::floor(angles[k] / angle_of_count(g, k));
    counts[k] = static_cast<int32_t>(exact) - g.home_counts[k];
  }
  return counts;
}

Pose handle_pose(const PolhemGeometry& g, const JointAngles& angles) {
  const Vec3 driven = driven_of(angles);
  const Quat turned = forearm_turn(g, driven) * turn_about({1, 0, 0}, angles[3]) *
                      turn_about({0, 1, 0}, angles[4]) * turn_about({1, 0, 0}, angles[5]);
  return {handle_place(g.linkage, driven), normalized(turned)};
}

bool solve_joint_angles(const PolhemGeometry& g, const Pose& X_BH, JointAngles& angles) {
  Vec3 driven;
  if (!solve_linkage(g.linkage, X_BH.p, driven)) return false;
  // what is left of the orientation, R(x, D) R(y, E) R(x, F), by its entries
  const Mat3 rest = to_matrix(conjugate(forearm_turn(g, driven)) * X_BH.q);
  const double sine = -std::hypot(rest.row[0].y, rest.row[0].z);
  double d = 0, f = std::atan2(-rest.row[1].z, rest.row[1].y);
  if (sine < -kInLine) {
    d = std::atan2(-rest.row[1].x, rest.row[2].x);
    f = std::atan2(-rest.row[0].y, -rest.row[0].z);
  }
  angles = {driven.x, driven.y, driven.z, d, std::atan2(sine, rest.row[0].x), f};
  return true;
}

MotorAmperes motor_currents(const PolhemGeometry& g, const JointAngles& angles, const Vec3& F_B) {
  MotorAmperes currents{};
  Mat3 J;
  if (!linkage_jacobian(g.linkage, driven_of(angles), J)) return currents;
  for (size_t k = 0; k < 3; ++k) {
    currents[k] = dot(J.column(static_cast<int>(k)), F_B) / torque_of_current(g, k);
  }
  return currents;
}

Vec3 handle_force(const PolhemGeometry& g, const JointAngles& angles,
                  const MotorAmperes& currents) {
  Mat3 J;
  if (!linkage_jacobian(g.linkage, driven_of(angles), J)) return {};
  const Vec3 a = J.column(0), b = J.column(1), c = J.column(2);
  // Cramer's rule: τ_i = column_i · F
  const double determinant = dot(a, cross(b, c));
  const PolhemLinkage& l = g.linkage;
  if (std::fabs(determinant) < kSingular * l.upper_arm * l.forearm * l.forearm) return {};
  std::array<double, 3> t;
  for (size_t k = 0; k < 3; ++k) t[k] = torque_of_current(g, k) * currents[k];
  return (t[0] * cross(b, c) + t[1] * cross(c, a) + t[2] * cross(a, b)) / determinant;
}

const Arm& polhem_arm() {
  // 100 m/s², where a count of C is 10 µm and more, one of A or B 25 µm
  constexpr double kMostOfC = 100 / 10e-6 * 1e-18;
  // 10,000 rad/s² of 163 counts: what a hand makes of the outer axes where they are nearly in line
  constexpr double kMostOfGimbal = 1.6e-12;
  static constexpr Arm kArm{
      .name = "Polhem",
      .model = 1,
      .motors = 3,
      .encoders = 6,
      .max_force = 5,
      .max_torque = 0,
      .most_acceleration = {kMostOfC, kMostOfC, kMostOfC, kMostOfGimbal, kMostOfGimbal,
                            kMostOfGimbal},
      .angles = [](const MotorCounts& n) { return joint_angles(kGeometry, n); },
      .counts = [](const JointAngles& q) { return motor_counts(kGeometry, q); },
      .pose = [](const JointAngles& q) { return handle_pose(kGeometry, q); },
      .solve = [](const Pose& X_BH,
                  JointAngles& q) { return solve_joint_angles(kGeometry, X_BH, q); },
      .currents = [](const JointAngles& q,
                     const Wrench& F_B) { return motor_currents(kGeometry, q, F_B.f); },
      .wrench =
          [](const JointAngles& q, const MotorAmperes& currents) {
            return Wrench{handle_force(kGeometry, q, currents), {}};
          },
  };
  return kArm;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "device-io/sensing/motor_counts.h"
#include "proto/config/device_config.h"
#include "proto/math/pose.h"

namespace haptic {

using MotorNumbers = std::array<int32_t, kMostMotors>;  // what a device tells its motors
using Milliamperes = MotorNumbers;                      // the same, of one that takes currents
using JointAngles = std::array<double, kMostMotors>;    // [rad]
/// Currents of motors [A], or their torques [N·m] where the device takes torques.
using MotorEfforts = std::array<double, kMostMotors>;
using LinkMasses = std::array<LinkMass, kMostLinks>;  // by DeviceRow::links
/// Column i: velocity and angular velocity of the handle in B, per velocity of joint i.
using HandleJacobian = std::array<Twist, kMostMotors>;

/// A joint with its encoder, and its motor if it has one.
struct Axis {
  double angle;                  // of the joint, by a count of the encoder [rad]
  int32_t home = 0;              // added to the counts
  double zero = 0;               // angle where counts and `home` are zero together [rad]
  double torque = 0;             // of the joint, by a unit of the motor's effort [N·m]
  double most_acceleration = 0;  // what hand or motor can reach [counts/ns²] (EncoderNoise)
};

/// Angle of a joint by a count [rad]: its encoder has `counts` a turn, which turn the joint
/// by 1/ratio, `direction` (±1) says which way.
double angle_of_count(double direction, double counts, double ratio = 1);

/// An arm of motors with encoders: its axes, first those with motors, and its kinematics as
/// functions that neither change anything, allocate nor throw. Handle poses are those of H in B,
/// wrenches those on the hand at the origin of H, in B.
struct Arm {
  std::string name;
  int32_t model = 0;        // in its answers; 0: they have none
  size_t motors = 3;        // at most `encoders`; of two it moves in the plane z = 0 of B
  size_t encoders = 3;      // at most kMostMotors
  uint32_t buttons = 0;     // that its answers can tell of
  double max_force = 0;     // limit of the design [N]
  double max_torque = 0;    // [N·m]; 0: it does not turn the hand
  double most_effort = 0;   // of a motor; 0: [device.serial] says, of one on a serial line
  double numbers = 1000;    // that a unit of effort is told as: thousandths
  double cutoff = 0;        // of the velocity [Hz]; 0: likewise
  Vec3 down_B{0, 0, -1};    // where gravity pulls, unless [device.gravity] says otherwise
  double least_volume = 0;  // of the first three columns of the Jacobian: singular below [m³]
  std::array<Axis, kMostMotors> axes{};

  /// The handle's pose; where it is found by iteration, X_BH is the start. False, and X_BH stays:
  /// no pose has these angles.
  std::function<bool(const JointAngles& q, Pose& X_BH)> find;
  /// False: the pose is singular.
  std::function<bool(const JointAngles& q, const Pose& X_BH, HandleJacobian& J)> jacobian;
  /// Joint angles of a handle at X_BH; false, and `q` stays, where the arm does not reach. Only
  /// emulators need it; empty: theirs is not ours.
  std::function<bool(const Pose& X_BH, JointAngles& q)> solve{};

  /// First moment of its links, Σ m p with p the centre of each in B [kg·m]; the handle is not
  /// among them. It may take the links' places from the angles or from the handle. Empty: it has no
  /// links that are known.
  std::function<Vec3(const LinkMasses& masses, const JointAngles& q, const Pose& X_BH)> links{};

  std::array<double, kMostMotors> most_accelerations() const;
  JointAngles angles(const MotorCounts& counts) const;
  /// The inverse, quantised as by an encoder: rounded down to whole counts.
  MotorCounts counts(const JointAngles& q) const;
  Pose pose(const JointAngles& q) const;
  /// The motors that exert a wrench, by joint torques τ = Jᵀ F. False, and they are zero, where the
  /// arm is singular. Friction and weight are not in it.
  bool efforts(const JointAngles& q, const Pose& X_BH, const Wrench& F_B, MotorEfforts& out) const;
  /// The wrench that motors exert, F = J⁻ᵀ τ, of an arm with three motors, or with six of which the
  /// last three turn the handle about its origin: their torques give the torque on the hand; what
  /// of the others does not hold against that is force. Zero where the arm is singular.
  Wrench wrench(const JointAngles& q, const MotorEfforts& motors) const;
  /// Computes it from the torques of the joints [N·m]; an arm of two motors has the force in its
  /// plane.
  Wrench wrench_of(HandleJacobian J, std::array<double, kMostMotors> torques) const;
};

/// Place in B of a point of a link: `c` in the link's own axes, of which x goes along the link and
/// y stays with `across`, both of length 1.
inline Vec3 link_place(const Vec3& from_B, const Vec3& along_B, const Vec3& across_B,
                       const Vec3& c) {
  return from_B + c.x * along_B + c.y * across_B + c.z * cross(along_B, across_B);
}

inline Quat turn_about(const Vec3& axis, double angle) {
  return from_rotation_vector(angle * axis);
}

/// x with a·x, b·x and c·x the components of t, by Cramer's rule. False, and x stays, where the
/// volume that a, b and c span is below `least`.
bool solve_rows(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& t, double least, Vec3& x);

}  // namespace haptic

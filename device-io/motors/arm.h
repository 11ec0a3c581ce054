// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "device-io/sensing/motor_counts.h"
#include "proto/math/pose.h"

namespace haptic {

using Milliamperes = std::array<int32_t, kMostMotors>;  // of the motors' currents
using MotorAmperes = std::array<double, kMostMotors>;   // the same [A]
using JointAngles = std::array<double, kMostMotors>;    // [rad]

/// A device of motors with encoders, driven over the line of protocol.h: how it answers, and its
/// kinematics as functions without state. Handle poses are those of H in B, wrenches those on the
/// hand at the origin of H, in B.
struct Arm {
  std::string_view name;
  int32_t model;         // in its answers
  size_t motors;         // the first of its encoders; at most kMostMotors
  size_t encoders;       // at most kMostMotors
  uint32_t buttons = 0;  // that its answers can tell of
  double max_force;      // limit of the design [N]
  double max_torque;     // [N·m]; 0: it does not turn

  /// Above what a hand, or the motors, can accelerate the motors' shafts [counts/ns²]
  /// (EncoderNoise).
  std::array<double, kMostMotors> most_acceleration;

  JointAngles (*angles)(const MotorCounts& counts);
  /// The inverse, quantised as by an encoder: rounded down to whole counts.
  MotorCounts (*counts)(const JointAngles& angles);
  Pose (*pose)(const JointAngles& angles);
  /// Joint angles of a handle at X_BH; false, and `angles` stays, where the arm does not reach.
  bool (*solve)(const Pose& X_BH, JointAngles& angles);
  /// τ = Jᵀ F, as currents.
  MotorAmperes (*currents)(const JointAngles& angles, const Wrench& F_B);
  /// F = J⁻ᵀ τ, the inverse; zero where the arm is singular.
  Wrench (*wrench)(const JointAngles& angles, const MotorAmperes& currents);
};

}  // namespace haptic

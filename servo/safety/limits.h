// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/pose.h"
#include "servo/safety/slew.h"

namespace haptic {

/// Limits of what the hand may feel, in device units: the smaller of the device's and the config's.
struct SafetyLimits {
  double max_force = 0;          // [N]
  double max_torque = 0;         // [N·m]; 0: torque is dropped and flagged
  double soft_start = 0.5;       // ramp from zero to full force [s]
  double continuous_force = 0;   // continuous rating of the motors [N]; 0: max_force
  double continuous_torque = 0;  // the same for torque [N·m]; 0: max_torque
  double slew = 2000;            // of a force that grows without motion of the hand [N/s]
  double torque_slew = 0;        // of a torque; 0: in as long as the force to its limit [N·m/s]
  double velocity_limit = 2;     // of the handle [m/s]
  double angular_velocity_limit = 20;    // [rad/s]
  Vec3 workspace_centre_B{};             // [m]
  double workspace_radius = 0;           // a soft edge pushes back beyond it [m]; 0: none
  Quat workspace_rest_B{};               // orientation of the handle in the middle of its range
  double workspace_turn = 0;             // a soft edge turns back beyond it [rad]; 0: none
  double max_damping = 2;                // bound of the passivity controller [N·s/m]
  double max_rotational_damping = 0.01;  // the same for turning [N·m·s/rad]
};

/// Largest change of the coupling's wrench per motion of the handle, in device units, while nothing
/// else moves.
struct HandleStiffness {
  double translational = 0;  // [N/m]
  double turning = 0;        // of the force by a rotation, when the tool is off the handle [N/rad]
  double rotational = 0;     // [N·m/rad]
  double lever = 0;          // distance from handle to tool, by which the force makes a torque [m]
};

/// Motion of the handle between the last two fresh samples; zero if this tick's is not fresh.
struct HandleMotion {
  double way = 0;   // translation [m]
  double turn = 0;  // rotation [rad]
};

/// Largest magnitudes of a wrench.
struct WrenchLimit {
  double force = 0;   // [N]
  double torque = 0;  // [N·m]
};

/// Load of the motors: the low-passed squares of force and torque.
struct MotorHeat {
  double force = 0;   // [N²]
  double torque = 0;  // [(N·m)²]
};

/// Shortens a vector to the limit, direction kept; returns whether it did. A limit of zero leaves
/// nothing.
bool saturate(Vec3& a, double limit);
/// Both parts of a wrench.
bool saturate(Wrench& F, const WrenchLimit& limit);

/// What the motors can sustain at present: over the last fifth below the square of the continuous
/// rating the limit falls from the largest to the continuous one, for force and torque each by its
/// own load.
WrenchLimit sustainable(const SafetyLimits& limits, const MotorHeat& heat);

/// The load after `dt` seconds under F: a low-pass of 10 s.
MotorHeat heated(const MotorHeat& heat, const Wrench& F_B, double dt);

/// Growth allowed over `since` seconds: slew, and the coupling's stiffness times the motion of the
/// handle. A force at the tool makes a torque at the handle, so the torque may also grow by the
/// lever times the force's growth.
WrenchGrowth most_growth(const SafetyLimits& limits, const HandleStiffness& stiffness,
                         const HandleMotion& motion, double since);

/// Rate at which a torque may grow by itself [N·m/s].
double torque_slew(const SafetyLimits& limits);

/// The soft edge: a spring towards the centre of the workspace from 5 mm beyond its radius on with
/// 30 % of max_force, and one towards its rest orientation, from 0.05 rad beyond workspace_turn on
/// with 30 % of max_torque; linear up to there.
Wrench edge_wrench(const SafetyLimits& limits, const Pose& X_BH);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/device_config.h"
#include "proto/math/vec3.h"

namespace haptic {

/// The torques that turn the handle in one step; everything in the device's base frame.
struct Turning {
  Vec3 torque_B;       // of the device [N·m]
  Vec3 twist_B;        // θ at the start: rotation vector from the intended orientation [rad]
  Vec3 w_B;            // angular velocity at the start [rad/s]
  Vec3 intent_turn_B;  // by which the intention turns in the step [rad]
};

struct TurningStep {
  Vec3 turn_B;         // rotation vector of the step [rad]
  Vec3 w_B;            // angular velocity at its end [rad/s]
  Vec3 on_hand_B;      // mean torque on the intention [N·m]
  double device_loss;  // in damping and friction [J]
  double hand_loss;    // in the hand's damping [J]
};

/// One step of h seconds of
///   J ω̇ + b_R ω + τ_c ω/|ω| = τ_d − k_R θ − b_Rh (ω − ω_h) − J_h ω̇
/// by the implicit midpoint rule. The inertia is the same about every axis, so that there is no
/// gyroscopic term, and friction brakes along the angular velocity: no axis is special. The handle
/// sticks where friction can absorb its angular momentum within the step. θ at the middle of the
/// step is θ + (turn − intent_turn)/2 plus what the rotation vector changes in addition where the
/// axes differ, taken from the start of the step: second order, and for turns about one axis the
/// exact midpoint.
TurningStep step_turning(const SimulatedHandConfig& config, const Turning& turning, double h);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/device_config.h"
#include "proto/math/pose.h"

namespace haptic {

/// The virtual body that the hand moves, at the handle, in B: where the device is commanded to be.
struct VirtualBody {
  Pose X_BH;
  Twist V_BH;
};

/// One step of M dV/dt + D V = F, the damping implicit:
///   V' = (M V + dt F)/(M + dt D),  X' = X ⊕ dt V'.
/// Its inertia is the same about every axis, so that no axis acts on another.
VirtualBody stepped(const AdmittanceConfig& model, const VirtualBody& body, const Wrench& F_B,
                    double dt);

/// Largest speeds of the body: of its origin [m/s] and of turning [rad/s].
struct SpeedLimit {
  double moving = 0;
  double turning = 0;
};

/// One step in which a force and a torque of at most that size brake the body to rest.
VirtualBody braked(const AdmittanceConfig& model, const VirtualBody& body, double max_force,
                   double max_torque, double dt);

/// The step to `to`, shortened to those speeds; direction kept.
VirtualBody bounded(const VirtualBody& from, const VirtualBody& to, const SpeedLimit& most,
                    double dt);

/// The body brought to a pose in one step: its velocity is what the step was.
VirtualBody brought_to(const VirtualBody& from, const Pose& X_BH, double dt);

/// Kinetic energy [J].
struct BodyEnergy {
  double moving = 0;
  double turning = 0;
};
BodyEnergy energy_of(const AdmittanceConfig& model, const Twist& V_BH);

}  // namespace haptic

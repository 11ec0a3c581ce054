// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/body/rigid_body.h"

namespace haptic {

/// Springs and dampers between hand and proxy.
struct VirtualCoupling {
  double translational_stiffness = 0;  // k_T [N/m]
  double translational_damping = 0;    // b_T [N·s/m]
  double rotational_stiffness = 0;     // k_R [N·m/rad]
  double rotational_damping = 0;       // b_R [N·m·s/rad]
  double max_force = 0;                // of the springs; 0: no bound [N]
  double max_torque = 0;               // [N·m]
};

/// Wrench of the coupling on the proxy about its centre of mass C, in W, with its Jacobians:
///   f = sat(k_T s) + b_T (v_T − v_P),  s = x_T − x_P between the two tool origins,
///   τ = sat(k_R θ) + b_R (ω_T − ω_P),  θ the rotation vector of R_T R_Pᵀ along the shorter arc,
/// f acting at the proxy's tool origin; sat bounds the length. Colgate, Stanley, Brown 1995;
/// McNeely, Puterbaugh, Troy 1999 (saturation).
BodyWrench coupling_wrench(const VirtualCoupling& coupling, const RigidBody& body,
                           const ToolMotion& hand, const BodyMotion& proxy);

/// The same with a Jacobian by motion that is symmetric and never pushes on, for solvers that need
/// a metric: the turning of the lever arm and of the springs is left out.
BodyWrench symmetric_coupling_wrench(const VirtualCoupling& coupling, const RigidBody& body,
                                     const ToolMotion& hand, const BodyMotion& proxy);

/// Stored in its springs [J]; coupling_wrench says it too, with much else.
double coupling_energy(const VirtualCoupling& coupling, const ToolMotion& hand,
                       const ToolMotion& proxy);

/// What the hand feels: the opposite, −f and −τ, at the origin of the tool as the hand holds it; f
/// is along the line between the two origins, so that shifting it there adds no moment, but for the
/// part of the damper across that line. Exactly zero where both move as one.
Wrench wrench_on_hand(const VirtualCoupling& coupling, const ToolMotion& hand,
                      const ToolMotion& proxy);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device-io/motors/arm.h"

namespace haptic {

/// The wrench on the handle, at its origin in B, by which an arm's motors hold up its links and its
/// handle where they are: no motor works on a motion that the weight pays for.
///
///   inputs  masses m with centres c (GravityConfig), joint angles q, handle X_BH, Jacobian J
///   M       Σ m p, with p(q) the centres in B: the arm's links, and X_BH c of the handle
///   U       potential energy, −9.81 m/s² · down · M
///   τ_i     ∂U/∂q_i, by the difference of U at q ± h e_i and X_BH moved by ± h J_i, h = 0.1 mrad
///   F       J⁻ᵀ τ, as of torques that motors exert
///   bound   2 evaluations of M for each motor; the difference is off by h²/6, a part in 10⁹
///
/// The handle's centre counts only where motors turn the handle: elsewhere the hand holds it, and
/// its mass counts at the origin of H. Zero without masses, and where the arm is singular.
Wrench holding_wrench(const Arm& arm, const GravityConfig& gravity, const JointAngles& q,
                      const Pose& X_BH);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/config/config.h"
#include "servo/solve/body/rigid_body.h"

namespace haptic {

/// The coupling with springs that a metric can be made of, for a tool of this radius [m].
Coupling with_least_springs(Coupling coupling, double radius);

/// diag(k_T, k_R), factored; none of them may be zero.
MotionMetric spring_metric(const Coupling& coupling);

/// Wrench of the coupling on the proxy about its centre of mass C, in W, with its Jacobians:
///   f = sat(k_T s) + b_T (v_T − v_P),  s = x_T − x_P between the two tool origins,
///   τ = sat(k_R θ) + b_R (ω_T − ω_P),  θ the rotation vector of R_T R_Pᵀ along the shorter arc,
/// f acting at the proxy's tool origin; sat bounds the length. Colgate, Stanley, Brown 1995;
/// McNeely, Puterbaugh, Troy 1999 (saturation).
BodyWrench coupling_wrench(const Coupling& coupling, const ToolBody& body, const ToolMotion& hand,
                           const BodyMotion& proxy);

/// As coupling_wrench, but the Jacobian by motion is symmetric and negative semidefinite, for
/// solvers that need a metric: derivatives of the lever arm and of the springs' directions by
/// rotation are left out.
BodyWrench symmetric_coupling_wrench(const Coupling& coupling, const ToolBody& body,
                                     const ToolMotion& hand, const BodyMotion& proxy);

/// Energy stored in the springs [J], the same as coupling_wrench gives.
double coupling_energy(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy);

/// Wrench the hand feels: −f and −τ, at the origin of the tool as the hand holds it. The springs' f
/// lies along the line between the two origins, so shifting it there adds no moment; the small
/// moment of the damper across that line is neglected. Exactly zero where both coincide and move as
/// one.
Wrench wrench_on_hand(const Coupling& coupling, const ToolMotion& hand, const ToolMotion& proxy);

}  // namespace haptic

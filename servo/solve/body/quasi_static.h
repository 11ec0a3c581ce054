// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/body/soft_contact.h"
#include "servo/solve/body/virtual_coupling.h"

namespace haptic {

struct QuasiStaticStep {
  double max_travel = 0;    // trust region: of any point of the body in one iteration [m]
  int max_iterations = 5;   // of Newton
  double tolerance = 1e-9;  // of the residual, of the largest force that acts
};

struct QuasiStaticResult {
  Pose X_WP;  // of the proxy, at the tool's origin
  int iterations = 0;
  double residual = 0;  // norm of the wrench that is left, torque over the body's radius [N]
  bool converged = false;
};

/// Equilibrium of a massless proxy between the coupling and the contacts: the minimum of
///   E(q) = ½ k_T |x_T − x_P|² + ½ k_R |θ|² + Σ ½ k_i d_i²
/// by Newton, δ = −K⁻¹ f with K = ∂f/∂q of all springs, a trust region on the way of every point of
/// the body, and a line search that halves until E sinks (at most twenty times). Starts at X_WP;
/// the dampers do nothing. Where nothing touches it is the hand to the last bit, and nothing is
/// felt. Wan & McNeely 2003.
QuasiStaticResult solve_quasi_static(const VirtualCoupling& coupling, const RigidBody& tool,
                                     const Pose& X_WT, std::span<const SoftContact> contacts,
                                     const Pose& X_WP, const QuasiStaticStep& step);

}  // namespace haptic

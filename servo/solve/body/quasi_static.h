// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/body/soft_contact.h"
#include "servo/solve/coupled_body.h"

namespace haptic {

struct QuasiStaticStep {
  double max_travel = 0;    // trust region: bound of any point's motion per iteration; 0: none [m]
  int max_iterations = 5;   // Newton iterations
  double tolerance = 1e-9;  // of the residual, relative to the largest force that acts
};

struct QuasiStaticResult {
  Pose X_WP;  // proxy, at the tool's origin
  int iterations = 0;
  double residual = 0;  // norm of the unbalanced wrench, torque over the body's radius [N]
  bool converged = false;
};

/// Equilibrium of a massless proxy between the coupling and the contacts: the minimum of
///   E(q) = ½ k_T |x_T − x_P|² + ½ k_R |θ|² + Σ ½ k_i d_i²
/// by Newton, δ = −K⁻¹ f with K = ∂f/∂q of all springs, with a trust region on the motion of every
/// point of the body and a line search that halves the step until E decreases (at most twenty
/// times). Starts at X_WP; dampers have no effect. Where nothing touches, the result is exactly
/// X_WT. Wan & McNeely 2003.
QuasiStaticResult solve_quasi_static(const Coupling& coupling, const ToolBody& tool,
                                     const Pose& X_WT, std::span<const SoftContact> contacts,
                                     const Pose& X_WP, const QuasiStaticStep& step);

}  // namespace haptic

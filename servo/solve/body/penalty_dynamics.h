// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/proxy_solver.h"
#include "servo/solve/body/soft_contact.h"

namespace haptic {

struct PenaltyStep {
  double dt = 1e-3;       // h [s]
  double max_travel = 0;  // bound of any point's motion in a step [m]; 0: none
};

struct PenaltyResult {
  BodyMotion body;
  bool was_cut = false;   // by max_travel
  bool is_solved = true;  // false: matrix singular or not finite; the body is at rest
};

/// One step of a rigid body under `wrench` (coupling, anything smooth) and one-sided contacts, in W
/// about its centre of mass, with the gyroscopic torque −ω × I_W ω, I_W = R I_C Rᵀ. Implicit: with
/// u = (v, ω), K = ∂f/∂q and D = ∂f/∂u (analytic, gyroscopic term included)
///   [M − h D − h² K] Δu = h (f + h K u),  u += Δu,  x += h v,  R ← exp([h ω]×) R
/// (Otaduy & Lin 2006). Deviation: a contact pushes as it is at the end of the step, approaching
/// ones included, and contacts that would pull are left out (active set, at most ten rounds), so
/// that a body falling onto a wall extracts no energy from it. The explicit and semi-implicit
/// integrators use the contacts that overlap at the start.
PenaltyResult penalty_dynamics_step(const ToolBody& tool, const BodyMotion& body,
                                    const BodyWrench& wrench, std::span<const SoftContact> contacts,
                                    Integrator integrator, const PenaltyStep& step);

}  // namespace haptic

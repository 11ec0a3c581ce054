// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/wire/proxy_solver.h"
#include "servo/solve/body/soft_contact.h"

namespace haptic {

struct PenaltyStep {
  double dt = 1e-3;       // h [s]
  double max_travel = 0;  // no point of the body moves further in a step; 0: no bound [m]
};

struct PenaltyResult {
  BodyMotion body;
  bool was_cut = false;   // by max_travel
  bool is_solved = true;  // false: the matrix was singular or not finite; the body rests
};

/// One step of a rigid body under `wrench` (coupling, anything smooth) and one-sided contacts, in W
/// about its centre of mass; −ω × I_W ω turns it, I_W = R I_C Rᵀ. Implicit: with u = (v, ω), K =
/// ∂f/∂q and D = ∂f/∂u (analytic, gyroscopic term included)
///   [M − h D − h² K] Δu = h (f + h K u),  u += Δu,  x += h v,  R ← exp([h ω]×) R
/// (Otaduy & Lin 2006; the seed). Deviation: a contact pushes by what it is at the end of the step,
/// approaching ones too, and those that would pull do nothing (an active set, ten rounds): so that
/// a body that falls onto a wall takes no energy out of it. Explicit and semi-implicit take the
/// contacts that overlap now.
PenaltyResult penalty_dynamics_step(const RigidBody& tool, const BodyMotion& body,
                                    const BodyWrench& wrench, std::span<const SoftContact> contacts,
                                    Integrator integrator, const PenaltyStep& step);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "servo/solve/body/penalty_dynamics.h"
#include "servo/solve/body/quasi_static.h"
#include "servo/solve/body/soft_contacts.h"

namespace haptic {

/// All that is constant.
struct SoftProxyModel {
  SoftSolver solver = SoftSolver::kQuasiStatic;
  Integrator integrator = Integrator::kImplicit;
  double contact_stiffness = 1000;  // of contacts that give none [N/m]
  double contact_damping = 0;       // [N·s/m]
  // bound of any point's motion in a tick, beyond the proven free space [m]; 0: none
  double max_travel = 0;
};

/// The state from tick to tick.
struct SoftProxyState {
  bool started = false;
  ToolMotion proxy;
};

/// One tick. The proxy starts at the hand. Direct: F = Σ f, τ = Σ r × f of the contacts at the
/// hand's pose, about the tool's origin. Otherwise the coupling's wrench on the hand, between this
/// tick's hand and this tick's proxy. If the contacts are not finite, the proxy is reset to the
/// hand.
///
/// Where the contacts prove the hand free (free_space.h) nothing is felt, and a massless proxy is
/// at the hand at any speed. Elsewhere a massless proxy starts from the nearest known free pose or
/// its last pose, whichever is nearer to the hand, and moves at most max_travel. A proxy with mass
/// moves at most max_travel beyond the free space around it.
BodySolution solve_soft_proxy(const SoftProxyModel& model, SoftProxyState& state,
                              const BodyTick& tick);

}  // namespace haptic

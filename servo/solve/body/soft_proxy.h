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
  RigidBody tool;
  VirtualCoupling coupling;
  double contact_stiffness = 1000;  // of contacts that name none [N/m]
  double contact_damping = 0;       // [N·s/m]
  // of any point of the proxy in a tick, beyond the space that contacts prove free; 0: no bound [m]
  double max_travel = 0;
};

/// All that survives a tick.
struct SoftProxyState {
  bool started = false;
  ToolMotion proxy;
};

struct SoftProxyTick {
  ToolMotion hand;
  const ContactSet* contacts = nullptr;  // null: none
  SoftCarry carry;
  double dt = 1e-3;  // [s]
};

/// One tick. The proxy begins at the hand. Direct: F = Σ f, τ = Σ r × f of the contacts where the
/// hand is, shifted to the tool's origin. Else the coupling's wrench on the hand, from this tick's
/// hand and this tick's proxy. Where the contacts are not finite the proxy is put to the hand.
///
/// Where the contacts prove the hand free (free_space.h) nothing is felt, and a proxy without mass
/// is at the hand, however fast that is. Else it begins at the nearest free pose, or where it was,
/// whichever is nearer to the hand, and goes max_travel from there. One with mass goes max_travel
/// further than the free space around it.
BodySolution solve_soft_proxy(const SoftProxyModel& model, SoftProxyState& state,
                              const SoftProxyTick& tick);

}  // namespace haptic

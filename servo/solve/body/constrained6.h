// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/coulomb.h"
#include "servo/solve/body/rigid_contacts.h"

namespace haptic {

/// All that survives a tick.
struct Constrained6State {
  bool started = false;
  BodyMotion body;
  Slides slides{};
};

/// One tick of a rigid body between the coupling and hard contacts with Coulomb's law at the level
/// of velocities, about its centre of mass C. Rows J_k = (n_k, r_k × n_k) and gaps are those of the
/// verified pose X_WG; x is the motion from there to the body.
///  1. Position: where x is behind a row, x ← argmin ½ |x' − x|_M s.t. J_k x' ≥ −gap_k, of which
///     dt / blend_time is gone in a tick. The velocity only turns along.
///  2. Velocity: the coupling implicit in springs and dampers, A = M + h B + h² K, symmetric (the
///     turning of the lever and of the springs is left out), A v_free = M v + h F, F the springs
///     and the damped velocity of the hand; then CoulombSolver with least speeds −(gap_k + J_k x)/h
///     relative to the moving object.
///  3. x += h v.
/// The hand feels the coupling. The gyroscopic torque is left out: so a turning body keeps its
/// energy, and a tool in a hand turns slowly.
///
/// It begins at the hand as far as the contacts let it. Source: Baraff 1994; velocity level as
/// Stewart & Trinkle 1996; coupling as in penalty_dynamics.
BodySolution solve_constrained6(const RigidProxyModel& model, Constrained6State& state,
                                CoulombSolver& solver, const RigidProxyTick& tick);

}  // namespace haptic

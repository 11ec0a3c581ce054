// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/coulomb.h"
#include "proto/math/lcp.h"
#include "servo/solve/body/rigid_contacts.h"

namespace haptic {

struct Constrained6Model {
  double blend_time = 3e-3;  // in which the body leaves rows that have moved into it [s]
  RigidSolver solver = RigidSolver::kCoulomb;
};

/// Memory of the solvers that Constrained6Model::solver chooses from; nothing persists in them.
/// Only the constructor allocates.
struct ContactSolvers {
  CoulombSolver coulomb{kMaxContacts};
  LcpSolver lcp{kMaxContacts};
};

/// The state from tick to tick.
struct Constrained6State {
  bool started = false;
  BodyMotion body;
  Slides slides{};
};

/// One tick of a rigid body between the coupling and hard contacts with Coulomb friction, at the
/// velocity level, about its centre of mass C. Rows J_k = (n_k, r_k × n_k) and gaps are those of
/// the verified pose X_WG; x is the motion from there to the body.
///
/// 1. Position: where x violates a row, x ← argmin ½ |x' − x|_M s.t. J_k x' ≥ −gap_k, relaxed so
///    that dt / blend_time of the violation is removed per tick. The spin turns with the body;
///    the velocity is otherwise unchanged.
/// 2. Velocity: springs and dampers of the coupling are implicit, A = M + h B + h² K, symmetric
///    (derivatives of lever arm and springs by rotation are left out), A v_free = M v + h F, F
///    their wrench; then CoulombSolver with least normal speeds −(gap_k + J_k x)/h relative to
///    the moving object. With RigidSolver::kLcp pivoting instead, without friction: the same to
///    rounding where rows are well apart; rows that are nearly parallel count as one (lcp.h). Where
///    pivoting fails, CoulombSolver takes its place.
/// 3. x += h v.
///
/// The hand feels the coupling. The gyroscopic torque is left out, so a spinning body keeps its
/// energy; a tool in a hand turns slowly. The body starts at the hand as far as the contacts allow.
/// Sources: Baraff 1994; velocity level as Stewart & Trinkle 1996; coupling as in penalty_dynamics.
BodySolution solve_constrained6(const Constrained6Model& model, const Materials& materials,
                                Constrained6State& state, ContactSolvers& solvers,
                                const BodyTick& tick);

}  // namespace haptic

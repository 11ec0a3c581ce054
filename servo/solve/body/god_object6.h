// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/coulomb.h"
#include "servo/solve/body/rigid_contacts.h"

namespace haptic {

/// All that survives a tick.
struct GodObject6State {
  bool started = false;
  uint32_t carrier = kNoBody;
  Pose X_CP;  // the last proxy, seen from the object that carries it, or from the world
  Slides slides{};
};

/// One tick of the god-object with six degrees of freedom, massless and hard, from the verified
/// pose X_WG of the contacts. Motions a = (translation of the tool's origin, rotation vector) from
/// X_WG; a_u leads to the hand; J_k = (n_k, r_k × n_k) about the tool's origin, where the coupling
/// acts:
///   a_c = argmin ½ (a − a_u)ᵀ K (a − a_u)  s.t. J_k a ≥ −gap_k,  K = diag(k_T, k_R),
///   X_WP = X_WG ⊕ a_c,  F_hand = K (a_c − a_u) = Σ λ_k J_k.
/// So the force lies in the cone of the contacts, and without one it is zero and X_WP is the hand,
/// both exactly. It is shortened where it exceeds max_force or max_torque, force and torque alike,
/// so that it stays in the cone. Contacts that come or go change it at once: the step of force that
/// the hand feels is rate-limited afterwards (servo/render/body_solver.h).
///
/// Damping moves each touching row by its own damped velocity, n·(b V)(r)/k: the sum stays in the
/// cone and never pulls. Friction: with last tick's proxy P (moved with its object, put onto the
/// rows) the motion a − a_P is the twist of CoulombSolver, metric K, free twist a_u − a_P: what
/// sticks stays where it is on the object. Shading and texture in two passes (Ruspini 1997; the
/// paper): ã with turned normals, ã projected onto the true rows, and the force points to there. A
/// turned row goes where it alone would end on the true one.
///
/// Source: Ortega, Redon & Coquillart 2007. Friction and damping are not in the paper.
BodySolution solve_god_object6(const Materials& materials, GodObject6State& state,
                               CoulombSolver& solver, const BodyTick& tick);

}  // namespace haptic

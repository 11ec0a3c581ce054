// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "proto/math/coulomb.h"
#include "servo/solve/body/rigid_contacts.h"

namespace haptic {

/// A plane that carried the proxy and is let out after it is gone.
struct FadingPlane {
  Vec3 tool_point_T, object_point_O, normal_O;
  double weight = 1;
  uint32_t object = 0, material = 0;
};

/// All that survives a tick.
struct GodObject6State {
  bool started = false;
  uint32_t carrier = kNoObject;
  // seen from the object that carries it, or from the world: the last proxy, the hand then, how far
  // shading moved it, and the force of both without damping, at the tool's origin
  Pose X_CP, X_CH;
  Twist shaded_C;
  Wrench F_C;
  std::array<double, 32> sizes{};  // of that force, round and round: blend_time at 10 kHz [N]
  size_t n_ticks = 0;
  std::array<FadingPlane, kMaxCarrying> fading;
  size_t n_fading = 0;
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
/// so that it stays in the cone.
///
/// Damping moves each touching row by its own damped velocity, n·(b V)(r)/k: the sum stays in the
/// cone and never pulls. Friction: with last tick's proxy P (moved with its object) the motion a −
/// a_P is the twist of CoulombSolver, metric K, free twist a_u − a_P: what sticks stays where it is
/// on the object. Shading and texture in two passes (Ruspini 1997; the paper): ã with turned
/// normals, ã projected onto the true rows, and the force points to there. A turned row goes where
/// it alone would end on the true one.
///
/// What comes or goes at once is blended on the rows: where last tick's proxy violates a row, only
/// dt / blend_time of the violation is asked for; a row that carried it is let out linearly towards
/// the hand in blend_time, unless another carries. Where planes meet at a sharp angle the proxy
/// slides far when one of them is let out by little; so, without friction, what is beyond
///   |ΔF| ≤ k_T (|Δhand| + |Δshading|) + dt / blend_time (F_out + F_in)
/// is put off to the next ticks: force and proxy are those between the last and the new ones. |F|
/// of a wrench is √(|f|² + |τ|² k_T/k_R), F_out the largest of the last blend_time, F_in that with
/// which all rows at once would push the last proxy. Then the last contacts are felt a few ticks
/// longer, even where there are none any more. With friction, and at weight 0, nothing is put off.
///
/// Source: Ortega, Redon & Coquillart 2007. Friction and damping are not in the paper.
BodySolution solve_god_object6(const RigidProxyModel& model, GodObject6State& state,
                               CoulombSolver& solver, const RigidProxyTick& tick);

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "proto/math/qp.h"

namespace haptic {

/// A point of a body against an obstacle, at lever arm r from the point of the twist. Unit normal
/// away from the obstacle.
struct FrictionContact {
  Vec3 r, normal;
  double least_speed = 0;  // along the normal: −gap / h, see contact_row [m/s]
  double friction = 0;     // μ ≥ 0
  Vec3 obstacle_velocity;  // of the obstacle at the contact, zero where it stands still
};

struct FrictionStep {
  Twist v;                         // after the step
  Wrench impulse;                  // of all contacts on the body, M (v − v_free)
  std::span<const Vec3> impulses;  // of each contact [N·s], in the solver's memory
  bool converged = false;          // false: v is that of the convex law, or nothing is finite
  bool contradictory = false;      // as in ConstrainedMotion
  int iterations = 0, solves = 0;  // of the fixed point; of the quadratic program
};

/// One step of a rigid body at the level of velocities with Coulomb's law at its contacts:
///   M (v − v_free) = Σ J_iᵀ λ_i, v_free = v_before + h M⁻¹ F; u_i the velocity of contact i
///   relative to the obstacle;
///   0 ≤ λ_n ⟂ u_n − least_speed ≥ 0, |λ_t| ≤ μ λ_n, and where it slips λ_t = −μ λ_n u_t / |u_t|.
///
/// With its shift s_i = μ |u_t| known the law is that of a convex problem: v is the twist nearest
/// to v_free with u_n − least_speed + s ≥ μ |u_t| at each contact. With the shift of a body at rest
/// (the convex law; zero where obstacles stand still) a sliding body would lift off by μ |u_t|. So
/// s is a fixed point, found by Broyden's method on v from rest, where plain iteration contracts by
/// μ² / (1 + μ²) or not at all. Each round cone is cut out of half-spaces u_n − least_speed + s ≥ μ
/// u_t·d where the last answer violates it most, with d its own direction of slip: no facets are
/// chosen beforehand, and as many are made as it takes until the cone is violated by no more than
/// 1e-12 of the speeds (1e-8 where rounding stops it). What is left is an error of the direction of
/// friction: √(2e-12 speed / (μ |u_t|)) rad, about 1e-6, more where the slip is slow beside the
/// body; none where it keeps its direction.
///
/// Bodies come to rest and stick; with gaps ≥ 0 and obstacles that stand still a step never adds
/// kinetic energy, converged or not, because each v is the projection of v_free onto a convex set
/// that contains v = 0. Not converged: the convex law's answer, which penetrates no obstacle that
/// stands still: see to it that one which carries the body does. Several solutions may exist
/// (jamming); one is found. λ need not be unique.
///
/// Source: De Saxcé & Feng 1998 (the change of variables); Acary, Cadoux, Lemaréchal & Malick 2011,
/// "A formulation of the linear discrete Coulomb friction problem via convex optimization".
class CoulombSolver {
 public:
  /// For at most `capacity` contacts. Allocates here, never in a step.
  explicit CoulombSolver(size_t capacity)
      : capacity_(capacity),
        rows_(kRowsPerContact * (capacity + 1)),
        owners_(rows_.size()),
        shifts_(capacity),
        lacks_(capacity),
        impulses_(capacity) {}

  /// No round of the fixed point begins after `max_solves` quadratic programs.
  FrictionStep step(const MotionMetric& metric, const Twist& v_free,
                    std::span<const FrictionContact> contacts, int max_solves = 3600);

 private:
  ConstrainedMotion solve_cones(const Twist& shift_of, double wanted, FrictionStep& out);
  double worst_lack(const Twist& v);
  void cut_cones(const Twist& v, double worst);
  double bound_of(const Vec3& direction, size_t i) const;
  void keep_active(ConstrainedMotion& motion);
  void add_up(const ConstrainedMotion& motion, FrictionStep& out);
  std::span<const MotionRow> rows() const { return {rows_.data(), n_rows_}; }

  static constexpr size_t kRowsPerContact = 8;

  size_t capacity_;
  const MotionMetric* metric_ = nullptr;
  Twist v_free_;
  double speed_ = 0;  // the largest that a contact has without the others
  std::span<const FrictionContact> contacts_;
  std::vector<MotionRow> rows_;  // half-spaces cut so far, n_rows_ of them
  std::vector<size_t> owners_;   // their contacts
  size_t n_rows_ = 0;
  std::vector<double> shifts_, lacks_;
  std::vector<Vec3> impulses_;
  std::array<int, 6> warm_{};
  size_t n_warm_ = 0;
};

}  // namespace haptic

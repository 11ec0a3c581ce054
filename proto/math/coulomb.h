// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "proto/math/qp.h"

namespace haptic {

/// A point of a body against an obstacle, at lever arm r from the reference point of the twist. The
/// unit normal points away from the obstacle.
struct FrictionContact {
  Vec3 r, normal;
  double least_speed = 0;  // bound of the normal speed: −gap / h, see contact_row [m/s]
  double friction = 0;     // μ ≥ 0
  Vec3 obstacle_velocity;  // of the obstacle at the contact [m/s]
};

struct FrictionStep {
  Twist v;                         // after the step
  Wrench impulse;                  // sum of the contacts' impulses on the body, M (v − v_free)
  std::span<const Vec3> impulses;  // of each contact [N·s], in the solver's memory
  bool converged = false;          // false: v is that of the convex law, or the input is not finite
  bool contradictory = false;      // as in ConstrainedMotion
  int iterations = 0, solves = 0;  // of the fixed point; of the quadratic program
};

/// One velocity-level step of a rigid body with Coulomb friction at its contacts:
///   M (v − v_free) = Σ J_iᵀ λ_i, v_free = v_before + h M⁻¹ F; u_i the velocity of contact i
///   relative to the obstacle;
///   0 ≤ λ_n ⟂ u_n − least_speed ≥ 0, |λ_t| ≤ μ λ_n, and where it slips λ_t = −μ λ_n u_t / |u_t|.
///
/// With the shift s_i = μ |u_t| given, the law is a convex problem: v is the twist nearest to
/// v_free with u_n − least_speed + s ≥ μ |u_t| at each contact. With the shift of a body at rest
/// (the convex law; zero if obstacles are at rest) a sliding body would lift off at μ |u_t|. So s
/// is iterated to a fixed point by Broyden's method on v, from rest; plain iteration contracts by
/// μ² / (1 + μ²) or not at all. Each round cone is approximated by cutting planes u_n − least_speed
/// + s ≥ μ u_t·d, added where the last solution violates it most, d its own direction of slip,
/// until the violation is at most 1e-12 of the speeds (1e-8 where rounding prevents that). The
/// error that remains is one of the direction of friction: √(2e-12 speed / (μ |u_t|)) rad, about
/// 1e-6, larger for slips slow relative to the body; none where the direction of slip is constant.
///
/// Bodies come to rest and stick. With gaps ≥ 0 and obstacles at rest a step never adds kinetic
/// energy, converged or not, since each v is the projection of v_free onto a convex set that
/// contains v = 0. Without convergence the result is that of the convex law, which penetrates no
/// obstacle at rest; callers must make sure that an obstacle which carries the body is at rest.
/// Several solutions may exist (jamming); one is found. λ need not be unique.
///
/// Sources: De Saxcé & Feng 1998 (change of variables); Acary, Cadoux, Lemaréchal & Malick 2011.
class CoulombSolver {
 public:
  /// For at most `capacity` contacts. Only the constructor allocates.
  explicit CoulombSolver(size_t capacity)
      : capacity_(capacity),
        rows_(kRowsPerContact * (capacity + 1)),
        owners_(rows_.size()),
        shifts_(capacity),
        lacks_(capacity),
        impulses_(capacity) {}

  /// Starts no new round of the fixed point after `max_solves` quadratic programs.
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

  static constexpr size_t kRowsPerContact = 8;  // capacity for cutting planes

  size_t capacity_;
  const MotionMetric* metric_ = nullptr;
  Twist v_free_;
  double speed_ = 0;  // largest speed at a contact before the step
  std::span<const FrictionContact> contacts_;
  std::vector<MotionRow> rows_;  // cutting planes, n_rows_ of them
  std::vector<size_t> owners_;   // contact of each
  size_t n_rows_ = 0;
  std::vector<double> shifts_, lacks_;
  std::vector<Vec3> impulses_;
  std::array<int, 6> warm_{};
  size_t n_warm_ = 0;
};

}  // namespace haptic

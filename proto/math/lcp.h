// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "proto/math/motion_metric.h"

namespace haptic {

/// f ≥ 0, a = A f + b ≥ 0, fᵀ a = 0. The spans lie in the solver's memory and are valid until the
/// next solve.
struct LcpSolution {
  std::span<const double> f, a;
  bool converged = false;  // false: not finite, too large, no solution, or iteration limit
  int iterations = 0;      // pivots or sweeps
};

/// Effect of the contacts on a body in one time step.
struct ImpulseStep {
  Twist v;                         // after the step; v_free if not converged
  std::span<const double> lambda;  // impulse of each row, ≥ 0 [N·s]
  bool converged = false;
  int iterations = 0;
};

enum class LcpMethod { kPivoting, kGaussSeidel };

/// Linear complementarity problems with symmetric positive semidefinite A, possibly singular: of
/// hundreds of contacts of one body at most six are independent. a is unique, f need not be. Only
/// the constructor allocates.
class LcpSolver {
 public:
  /// For problems of at most `capacity` unknowns.
  explicit LcpSolver(size_t capacity)
      : capacity_(capacity),
        f_(capacity),
        a_(capacity),
        df_(capacity),
        da_(capacity),
        clamped_(capacity),
        side_(capacity),
        L_(capacity * capacity),
        x_(capacity),
        g_(capacity),
        own_A_(capacity * capacity),
        own_b_(capacity) {}

  /// A is b.size() × b.size(), by rows.
  ///
  /// kPivoting: drives one index d after the other to a_d = 0. Its force grows; the forces of the
  /// clamped set C (a = 0) change so that a stays zero there, A_CC Δf_C = −A_Cd. A step ends where
  /// the first force of C reaches zero (its index leaves C), where an index outside C reaches a = 0
  /// (it enters), or where a_d = 0. An index dependent on C changes no a, it only moves force
  /// between members of C; so A_CC is never singular. Ties go to the lowest index. A squares the
  /// condition number of the rows: two that differ in direction by less than about 1e-4 may be
  /// treated as one or fail, which is flagged; least_constraint resolves 1e-10. Source: Baraff
  /// 1994.
  ///
  /// kGaussSeidel: f_i ← max(0, f_i − a_i / A_ii) in turn, at most `max_sweeps` sweeps, until no
  /// a_i changes by more than rounding. Linear convergence, slow with redundant rows.
  LcpSolution solve(LcpMethod method, std::span<const double> A, std::span<const double> b,
                    int max_sweeps = 200);

  /// One velocity-level step of a body: M (v − v_free) = Σ λ_k J_k, 0 ≤ λ_k ⟂ J_k·v − b_k ≥ 0, with
  /// v_free = v_before + h M⁻¹ F and b_k = −gap_k / h (contact_row). These are the optimality
  /// conditions of least_constraint: v is the same, λ need not be. For several bodies use solve()
  /// with their joint A.
  ImpulseStep step(LcpMethod method, const MotionMetric& metric, const Twist& v_free,
                   std::span<const MotionRow> rows, int max_sweeps = 200);

 private:
  /// Unseen: f = 0 and any a. Open: f = 0, a ≥ 0. Clamped: f ≥ 0, a = 0.
  enum class Side : char { kUnseen, kOpen, kClamped };

  bool pivot(int& iterations);
  bool drive_to_zero(size_t d, int& iterations);
  bool sweep(int max_sweeps, int& iterations);
  void find_direction(size_t d);
  void reverse();
  size_t first_event(size_t d, size_t first, double& step) const;
  void enter(size_t i);
  void leave(size_t i);
  void factor_from(size_t place);
  void solve_clamped(std::span<double> x) const;
  void update_a();
  bool is_solved() const;
  double noise() const;
  std::span<size_t> clamped_set() { return {clamped_.data(), n_clamped_}; }
  double entry(size_t i, size_t j) const { return A_[i * n_ + j]; }

  size_t capacity_, n_ = 0;
  std::span<const double> A_, b_;
  double largest_A_ = 0, largest_b_ = 0;
  std::vector<double> f_, a_, df_, da_;
  std::vector<size_t> clamped_;  // C in the order of the factor, n_clamped_ of them
  size_t n_clamped_ = 0;
  std::vector<Side> side_;
  std::vector<double> L_, x_;  // Cholesky factor of A_CC, n × n; a right-hand side
  std::vector<Vec6> g_;        // of step()
  std::vector<double> own_A_, own_b_;
};

}  // namespace haptic

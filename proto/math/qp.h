// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "proto/math/motion_metric.h"

namespace haptic {

struct ConstrainedMotion {
  Twist a;                      // always finite
  Wrench constraint;            // M (a − a_u) = Σ multiplier·J: wrench of the rows on the body
  int n_active = 0;             // ≤ 6
  std::array<int, 6> active{};  // indices of the active rows
  std::array<double, 6> multiplier{};  // ≥ 0
  // false: input not finite or M not positive definite (both: a = 0, no wrench), or the iteration
  // limit (a is the last iterate; never seen in a million random problems)
  bool converged = false;
  bool contradictory = false;  // no acceptable motion satisfies all rows: a is that of min(b, 0)
  int iterations = 0;          // rows added and dropped
};

/// Gauss' principle of least constraint: the motion nearest to the unconstrained one that satisfies
/// the rows, min ½ (a − a_u)ᵀ M (a − a_u) s.t. J_k·a ≥ b_k. If a_u violates no row, a is a_u and
/// the wrench zero, both exactly; else the wrench lies in the cone of the active rows.
///
/// In y = Lᵀ(a − a_u) this is the point of a polyhedron nearest to the origin, found by a dual
/// active-set method: the most violated row is added, rows whose multiplier reaches zero are
/// dropped; |y| increases with each row, so no set recurs. At most six independent rows are active.
/// Point and multipliers are recomputed from the set each time, so nothing drifts. Rows within
/// 1e-10 of dependent on the active ones are treated as dependent, and violations too small to tell
/// from that are ignored.
///
/// `warm` (warm start): rows that were active before, most important first. They are added before
/// others if violated: the result is the cold one to rounding, in fewer iterations. Indices out of
/// range are ignored.
///
/// Rows with b > 0 (overlaps that push out, contact_row) may contradict one another, as in a hole
/// too tight for its peg, or admit only an excessive motion, |a|_M larger than |a_u|_M plus a
/// hundred times the deepest overlap, as in a wedge of less than half a degree. The result is then
/// that with min(b, 0), which a = 0 always satisfies, and is flagged. Row lengths should be
/// comparable (unit normals), since violations J·a − b are compared unscaled.
///
/// Sources: Goldfarb & Idnani 1983 (dual active set); Redon, Kheddar & Coquillart 2002 and Ortega,
/// Redon & Coquillart 2007 (Gauss' principle for rigid contact).
ConstrainedMotion least_constraint(const MotionMetric& metric, const Twist& a_u,
                                   std::span<const MotionRow> rows, std::span<const int> warm = {});

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "proto/math/motion_metric.h"

namespace haptic {

struct ConstrainedMotion {
  Twist a;                      // finite in any case
  Wrench constraint;            // M (a − a_u) = Σ multiplier·J: what the rows do to the body
  int n_active = 0;             // ≤ 6
  std::array<int, 6> active{};  // indices of the rows that carry a
  std::array<double, 6> multiplier{};  // ≥ 0: how hard each pushes
  // false: something is not finite or M not positive definite (both: a = 0, no wrench); or the
  // limit of iterations, of which a is the last; never seen on a million random problems
  bool converged = false;
  bool contradictory = false;  // no motion within reason satisfies all rows: a is that of min(b, 0)
  int iterations = 0;          // rows taken in, and given up again
};

/// Gauss' principle of least constraint: the motion nearest to the unconstrained one that the rows
/// allow, min ½ (a − a_u)ᵀ M (a − a_u) s.t. J_k·a ≥ b_k. Without a violated row a is a_u and the
/// wrench is zero, both exactly; else the wrench lies in the cone of the active rows.
///
/// In y = Lᵀ(a − a_u) this is the point of a polyhedron nearest to the origin, found by a dual
/// active set: the most violated row is taken in, the rows whose multiplier reaches zero on the way
/// are given up; |y| grows with each row, so that no set comes twice. At most six independent rows
/// carry a, however many there are. Each time the point and the multipliers are computed anew from
/// the set, so nothing drifts. A row is dependent on the active ones where less than 1e-10 of it is
/// left beside them; what that cannot tell from zero is not pursued.
///
/// `warm`: rows that were active before, most telling first. They are taken in before others where
/// they are violated: the answer is the cold one to rounding, the way to it shorter; indices out of
/// range are ignored.
///
/// Rows with b > 0 (overlaps that push out, contact_row) may contradict one another, as in a hole
/// too tight for its peg, or only be satisfied by a motion beyond reason: |a|_M greater than
/// |a_u|_M and a hundred times the deepest overlap, as in a wedge of less than half a degree. The
/// body would be stuck or fly off. The answer is then that with min(b, 0), which a = 0 always
/// satisfies, and is flagged. Lengths of rows should be comparable (unit normals): "most violated"
/// is J·a − b as it is.
///
/// Source: Goldfarb & Idnani 1983 (dual active set); Redon, Kheddar & Coquillart 2002 and Ortega,
/// Redon & Coquillart 2007 (Gauss' principle for rigid contact).
ConstrainedMotion least_constraint(const MotionMetric& metric, const Twist& a_u,
                                   std::span<const MotionRow> rows, std::span<const int> warm = {});

}  // namespace haptic

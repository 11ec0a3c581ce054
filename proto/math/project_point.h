// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "proto/math/vec3.h"

namespace haptic {

/// Points x with normal·x ≥ offset; normal is a unit vector.
struct HalfSpace {
  Vec3 normal;
  double offset = 0;
};

struct PointProjection {
  Vec3 x;
  int n_active = 0;                    // 0 free, 1 face, 2 edge, 3 vertex
  std::array<int, 3> active{};         // the active set
  std::array<double, 3> multiplier{};  // > 0, x − p = Σ multiplier·normal
  bool converged = true;  // false: contradictory or non-finite half-spaces, or iteration limit
  int iterations = 0;
};

/// Point of the intersection of the half-spaces nearest to p: min ½|x − p|² s.t. n_i·x ≥ d_i.
///
/// Dual active set: starts without constraints and adds the most violated half-space. Of the
/// subsets of this larger set with at most three members, it takes the one whose Lagrange point is
/// feasible for the whole set with multipliers ≥ 0, and repeats. |x − p| strictly increases, so no
/// set recurs, and planes that would have to pull are dropped. Subsets with linearly dependent
/// normals are skipped. For contradictory half-spaces converged = false and x solves those added
/// before. Sources: Zilles & Salisbury 1995 (Lagrange form); KKT signs as in Ruspini et al. 1997.
PointProjection project_onto_half_spaces(const Vec3& p, std::span<const HalfSpace> half_spaces);

}  // namespace haptic

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
  std::array<int, 3> active{};         // indices of the half-spaces that carry x
  std::array<double, 3> multiplier{};  // > 0: how hard each pushes, x − p = Σ multiplier·normal
  bool converged = true;  // false: contradictory or non-finite half-spaces, or iteration limit
  int iterations = 0;
};

/// Point of the intersection of the half-spaces nearest to p: min ½|x − p|² s.t. n_i·x ≥ d_i.
///
/// Dual active set with multiplier signs: start free; take the most violated half-space; among the
/// subsets of (active set + it) with at most three members pick the one whose Lagrange point is
/// feasible for all of them with multipliers ≥ 0; repeat. The distance |x − p| grows strictly at
/// each step, so no set comes twice and planes that do not push are dropped (the over-constraint
/// trap). Linearly dependent normals make a subset singular: it is skipped (the prism trap).
/// Contradictory half-spaces: converged = false and x solves the ones taken before.
/// Source: Zilles & Salisbury 1995 (Lagrange form); KKT signs as in Ruspini 1997.
PointProjection project_onto_half_spaces(const Vec3& p, std::span<const HalfSpace> half_spaces);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/convex/hull.h"
#include "proto/math/pose.h"

namespace haptic::test {

/// Smallest support of A ⊕ (−B), b at X_AB: all facets of it, which are (face, vertex), (vertex,
/// face), and (edge, edge) where the arcs of the edges' normals cross. Negative: apart. [m]
double brute_penetration(const Hull& a, const Hull& b, const Pose& X_AB);

/// Distance of the surfaces of two hulls by all pairs of a face and a vertex and of two edges [m].
double brute_distance(const Hull& a, const Hull& b, const Pose& X_AB);

}  // namespace haptic::test

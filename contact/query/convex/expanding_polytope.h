// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/convex/gauss_overlay.h"

namespace haptic {

/// Where the Minkowski difference is nearest to the origin.
struct PolytopeDepth {
  Vec3 normal_A;     // unit
  double depth = 0;  // of that direction [m]; negative: the hulls are apart along it
  uint32_t vertex_a = 0, vertex_b = 0;  // its supports
  bool exact = false;  // false: the room or the work was not enough; the depth is an upper bound
};

/// The smallest support of A ⊕ (−B) over all directions, by the expanding polytope algorithm (van
/// den Bergen 2001) without a simplex to begin with: the polytope grows at the face of the smallest
/// signed distance, until no face is nearer than a known support, or one is negative: the hulls are
/// apart. It shares no state with a walk on the overlay and has no local minima; at most 200
/// expansions, some 5 to 60 µs.
PolytopeDepth expand_polytope(const HullPair& pair);

}  // namespace haptic

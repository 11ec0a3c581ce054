// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/lab/eval/scenes/rest_work.h"
#include "clients/report/report.h"

namespace haptic {

/// Extent of the rest-position test for point and sphere renderers.
struct RestEval {
  uint64_t meshes = 20;   // spiky meshes for the point; a fifth of them for the sphere
  uint64_t ticks = 3000;  // per hand and mesh
  uint64_t every = 15;    // ticks between two rest positions tested by segments
  int directions = 400;   // number of segments per position
  uint64_t seed = 1;
};

/// Counts from one hand on one mesh.
struct RestCount {
  uint64_t touching = 0;  // ticks in contact
  uint64_t restless = 0;  // of them, not in a local minimum by every facet near the proxy
  uint64_t limits = 0;    // of them, with a slide cut short by the iteration limit
  uint64_t judged = 0;    // rest positions tested by segments
  uint64_t caught = 0;    // of them: a free straight segment lowers the force by more than 1 mN
  uint64_t inside = 0;    // of them: the verified proxy is inside the mesh, exactly
  double worst = 0;       // largest reduction of the force by a segment [N]
  double of_force = 0;    // force at that position [N]

  void add(const RestCount& other);
};

/// Leads a point (radius 0) or a sphere over a closed mesh, in lockstep, answered within the tick.
/// Rest positions of a point are also tested by random segments, which know no half-spaces. The
/// obstacles of a sphere are smooth, so its half-spaces suffice.
RestCount judge_rests(const Soup& soup, RestHand hand, double radius, const RestEval& eval,
                      uint64_t seed);

/// `hapt eval rest`.
void eval_rest(const RestEval& eval, const Rows& all);

}  // namespace haptic

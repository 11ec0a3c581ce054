// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/eval/scenes/rest_work.h"
#include "clients/report/report.h"

namespace haptic {

/// How long a renderer of a point is judged by its places of rest, and from how many ways.
struct RestEval {
  uint64_t meshes = 20;   // spiky ones for the point; for the sphere a fifth of them
  uint64_t ticks = 3000;  // of each hand on each mesh
  uint64_t every = 15;    // ticks between two places that ways are tried from
  int directions = 400;   // of these ways
  uint64_t seed = 1;
};

/// What a hand on a mesh shows of the places where the proxy comes to rest.
struct RestCount {
  uint64_t touching = 0;  // ticks in contact
  uint64_t restless = 0;  // of them, not in a local minimum by every facet near the proxy
  uint64_t limits = 0;    // of them, with a slide that was cut short
  uint64_t judged = 0;    // places that ways are tried from
  uint64_t caught = 0;    // of them: a free straight way lowers the force by more than 1 mN
  uint64_t inside = 0;    // of them: the verified proxy is inside the mesh, exactly
  double worst = 0;       // most that such a way takes from the force [N]
  double of_force = 0;    // and the force there [N]

  void add(const RestCount& other);
};

/// A point (radius 0) or a sphere that a hand leads over a closed mesh, in lockstep, answered
/// within the tick. Places of a point are judged by ways taken at random too, which know no
/// half-spaces; what holds a sphere is smooth, so that its half-spaces are all there is to know.
RestCount judge_rests(const Soup& soup, RestHand hand, double radius, const RestEval& eval,
                      uint64_t seed);

/// The whole of `hapt eval --suite rest`.
std::vector<Row> eval_rest(const RestEval& eval);

}  // namespace haptic

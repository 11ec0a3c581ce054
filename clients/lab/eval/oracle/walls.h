// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <span>

#include "clients/lab/eval/oracle/long3.h"

namespace haptic {

inline constexpr long double kStandOff = 1e-12L;   // [m]; a sweep stops this far before an obstacle
inline constexpr long double kStill = 1e-15L;      // [m]; a shorter step is no progress
inline constexpr long double kEdgeSlack = 1e-16L;  // [m]; facets are this much larger: no cracks
inline constexpr double kTouch = 1e-9;             // [m]; a facet this close is touched

/// Half-space n·y ≥ offset.
struct Wall {
  Long3 normal;
  long double offset = 0;
};

struct NearestInWalls {
  Long3 y;
  size_t n_active = 0;
  std::array<size_t, 3> active{};  // indices of the walls in the active set
};

/// min |y − q| over the half-spaces by enumeration: the nearest feasible point among the Lagrange
/// points of every subset of up to three. The minimum is one of them, so no multiplier is needed.
/// Empty if no subset gives a feasible point.
std::optional<NearestInWalls> nearest_in(std::span<const Wall> walls, const Long3& q);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <span>

#include "clients/eval/oracle/long3.h"

namespace haptic {

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

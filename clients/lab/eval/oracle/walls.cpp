// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/oracle/walls.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr long double kFeasible = 1e-17L;   // [m]; allowed violation
constexpr long double kDependent = 1e-13L;  // sine or volume of unit normals below this: dependent

/// Nearest point to q on all planes of a subset; nothing if they are dependent.
std::optional<Long3> nearest_on(std::span<const Wall> walls, std::span<const size_t> subset,
                                const Long3& q) {
  const auto gap = [&](size_t i) {
    const Wall& wall = walls[subset[i]];
    return wall.offset - dot(wall.normal, q);
  };
  if (subset.empty()) return q;
  const Long3& n0 = walls[subset[0]].normal;
  if (subset.size() == 1) return q + gap(0) * n0;
  const Long3& n1 = walls[subset[1]].normal;
  const Long3 along = cross(n0, n1);
  if (subset.size() == 2) {
    const long double sine2 = dot(along, along);
    if (sine2 < kDependent * kDependent) return std::nullopt;
    return q + (1 / sine2) * (gap(0) * cross(n1, along) + gap(1) * cross(along, n0));
  }
  const Long3& n2 = walls[subset[2]].normal;
  const long double volume = dot(along, n2);
  if (std::fabs(volume) < kDependent) return std::nullopt;
  return q + (1 / volume) * (gap(0) * cross(n1, n2) + gap(1) * cross(n2, n0) + gap(2) * along);
}

}  // namespace

std::optional<NearestInWalls> nearest_in(std::span<const Wall> walls, const Long3& q) {
  std::optional<NearestInWalls> best;
  long double best_distance = 0;
  const auto consider = [&](std::span<const size_t> subset) {
    const std::optional<Long3> y = nearest_on(walls, subset, q);
    if (!y) return;
    const long double distance = norm(*y - q);
    if (best && distance >= best_distance) return;
    const bool feasible = std::all_of(walls.begin(), walls.end(), [&](const Wall& wall) {
      return dot(wall.normal, *y) - wall.offset >= -kFeasible;
    });
    if (!feasible) return;
    best = {*y, subset.size(), {}};
    std::copy(subset.begin(), subset.end(), best->active.begin());
    best_distance = distance;
  };
  consider({});
  for (size_t i = 0; i < walls.size(); ++i) {
    consider(std::array{i});
    for (size_t j = 0; j < i; ++j) {
      consider(std::array{i, j});
      for (size_t k = 0; k < j; ++k) consider(std::array{i, j, k});
    }
  }
  return best;
}

}  // namespace haptic

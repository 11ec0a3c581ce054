// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/shell_coherence.h"

#include <algorithm>
#include <limits>
#include <span>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// error of an interpolated distance, in cells: half the diagonal √3/2, rounded up for the
// quantisation of the stored values
constexpr double kFieldError = 0.87;
// Lipschitz constant of the interpolation: √3, rounded up likewise
constexpr double kSteepest = 1.74;
constexpr double kFarthest = 1e3;  // [m]; beyond, the sums are too inexact
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Largest travel of a point of the shell: |ΔR p + Δt| is convex in p, so its maximum is at a
/// corner of the bounding box.
double travel_between(const Pose& before, const Pose& after, std::span<const Vec3> corners_T) {
  double travel = 0;
  for (const Vec3& p_T : corners_T) {
    travel = std::max(travel, norm(after * p_T - before * p_T));
  }
  return travel;
}

}  // namespace

ShellCoherence::ShellCoherence(const Pointshell& shell)
    : free_until(shell.nodes.size(), 0), low(shell.x.size(), 0), high(shell.nodes.size(), 0) {
  if (shell.x.empty()) return;
  const auto [x0, x1] = std::minmax_element(shell.x.begin(), shell.x.end());
  const auto [y0, y1] = std::minmax_element(shell.y.begin(), shell.y.end());
  const auto [z0, z1] = std::minmax_element(shell.z.begin(), shell.z.end());
  for (size_t i = 0; i < corners_T.size(); ++i) {
    corners_T[i] = {static_cast<double>((i & 1) != 0 ? *x1 : *x0),
                    static_cast<double>((i & 2) != 0 ? *y1 : *y0),
                    static_cast<double>((i & 4) != 0 ? *z1 : *z0)};
  }
}

void note_travel(const Pose& X_OT, double reach, ShellCoherence& coherence) {
  // rounded up
  const double travel = travel_between(coherence.X_OT, X_OT, coherence.corners_T) * (1 + 1e-12) +
                        1e-15 * (1 + coherence.slack);
  coherence.slack += kSteepest * travel;
  // an increased reach acts like an approach by the same distance
  coherence.wear += travel + std::max(reach - coherence.reach, 0.0);
  // large or non-finite sums are not exact enough
  const bool is_exact = coherence.slack < kFarthest && coherence.wear < kFarthest;
  if (coherence.is_fresh || !is_exact) {
    std::fill(coherence.free_until.begin(), coherence.free_until.end(), 0.0);
    std::fill(coherence.low.begin(), coherence.low.end(), -kInfinite);
    std::fill(coherence.high.begin(), coherence.high.end(), kInfinite);
    coherence.slack = coherence.wear = 0;
    coherence.is_fresh = false;
  }
  coherence.X_OT = X_OT;
  coherence.reach = reach;
}

double way_to(double reach, const FieldDistance& at, double cell) {
  HAPTIC_ASSERT(cell > 0);
  const double less = at.distance - reach;
  // outside the band the value is a bound of the true distance
  if (!at.is_near) return less - kFieldError * cell;
  return std::max(less / kSteepest, less - 2 * kFieldError * cell);
}

double low_end(const DistanceField& field, const FieldDistance& at) {
  if (at.is_near) return at.distance;
  // outside the band the true distance is known, whose Lipschitz constant is 1
  const double low = at.distance - kFieldError * field.cell, beyond = low - field.band;
  return beyond > 0 ? field.band + kSteepest * beyond : low;
}

double travel_until(double low, double reach, const ShellCoherence& coherence) {
  return (low - coherence.slack - reach) / kSteepest;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/guide_rows.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr int kNewtonSteps = 4;        // quadratic: half a radian to rounding
constexpr double kIndependent = 1e-6;  // sine of the angle to the rows before, in the metric

bool is_sound_row(const GuideRow& row) {
  return is_finite(row.tool_point_T) && is_finite(row.object_point_O) && is_finite(row.normal_O);
}

/// J·a = b at a pose of the tool.
MotionRow row_at(const GuideRow& row, const Pose& X_WO, const Pose& X_WT) {
  const Vec3 normal_W = rotate(X_WO.q, row.normal_O);
  const Vec3 r_W = rotate(X_WT.q, row.tool_point_T);
  const double gap = dot(normal_W, X_WT.p + r_W - X_WO * row.object_point_O);
  return {{normal_W, cross(r_W, normal_W)}, -gap};
}

/// The motion from X_WT that satisfies the rows there and is nearest to `wanted`.
Twist newton_step(const GuideRows& guides, const Pose& X_WO, const Pose& X_WT, const Twist& wanted,
                  const MotionMetric& metric) {
  std::array<Vec6, 6> basis;
  size_t n = 0;
  // of the correction to `wanted`, orthonormal coordinates
  Vec6 y{};
  for (const GuideRow& guide : guides.rows) {
    const MotionRow row = row_at(guide, X_WO, X_WT);
    Vec6 w = whitened(metric, {row.J.v.x, row.J.v.y, row.J.v.z, row.J.w.x, row.J.w.y, row.J.w.z});
    const double lack = row.b - dot(row.J, wanted) - dot(w, y);
    const double whole = std::sqrt(dot(w, w));
    for (size_t k = 0; k < n; ++k) add_scaled(w, -dot(w, basis[k]), basis[k]);
    const double rest = std::sqrt(dot(w, w));
    if (!(rest > kIndependent * whole) || n == basis.size()) continue;
    basis[n] = {};
    add_scaled(basis[n], 1 / rest, w);
    add_scaled(y, lack / rest, basis[n]);
    ++n;
  }
  return wanted + motion_of(metric, y);
}

}  // namespace

GuideRows guide_rows(const ContactSet& set) {
  if (set.guides.empty()) return {};
  const uint32_t object = set.guides[0].object;
  const bool are_sound = std::ranges::all_of(
      set.guides, [&](const GuideRow& row) { return row.object == object && is_sound_row(row); });
  return are_sound ? GuideRows{set.guides, object} : GuideRows{};
}

Pose nearest_on_guides(const GuideRows& guides, const Pose& X_WO, const Pose& X_WT,
                       const Pose& start, const MotionMetric& metric) {
  if (!metric.valid) return X_WT;
  Pose X = start;
  for (int step = 0; step < kNewtonSteps; ++step) {
    X = moved(X, newton_step(guides, X_WO, X, way_between(X, X_WT), metric));
    X.q = normalized(X.q);
  }
  return X;
}

}  // namespace haptic

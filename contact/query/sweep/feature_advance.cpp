// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/feature_advance.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMostSteps = 48;         // of one advance
constexpr double kShortOf = 1 - 1e-9;  // shortens a step by more than its rounding

/// x limited to [0, 1].
double clamped(double x) {
  return std::clamp(x, 0.0, 1.0);
}

/// Parameter in [0, 1] of the point of the segment 0 … e that is closest to p.
double closest_on_segment(const Vec3& p, const Vec3& e) {
  const double ee = norm_squared(e);
  return ee > 0 ? clamped(dot(p, e) / ee) : 0;
}

/// Closest point to p on the border of the triangle 0, e, f.
std::array<double, 2> closest_on_sides(const Vec3& p, const Vec3& e, const Vec3& f) {
  const double u = closest_on_segment(p, e), v = closest_on_segment(p, f),
               w = closest_on_segment(p - e, f - e);
  const std::array<std::array<double, 2>, 3> sides{{{u, 0}, {0, v}, {1 - w, w}}};
  const auto squared = [&](const std::array<double, 2>& at) {
    return norm_squared(p - at[0] * e - at[1] * f);
  };
  const auto* nearest = &sides[0];
  for (const auto& side : {&sides[1], &sides[2]}) {
    if (squared(*side) < squared(*nearest)) nearest = side;
  }
  return *nearest;
}

/// Minimum of n·F over the features.
double least_along(const Vec3& n, const Slice& s, bool is_triangle) {
  const double e = std::max(dot(n, s.e), 0.0), f = std::max(dot(n, s.f), 0.0);
  return dot(n, s.base) - (is_triangle ? std::max(e, f) : e + f);
}

/// A separating direction and its gap.
struct Parting {
  Vec3 n;
  double gap, distance;
};

/// The direction between the closest points; where rounding dominates it, the normal of both
/// features.
Parting part(const Slice& s, bool is_triangle) {
  const auto [u, v] = closest_of(s, is_triangle);
  const Vec3 way = s.base - u * s.e - v * s.f;
  const double distance = norm(way);
  if (!(distance > 0)) return {way, 0, distance};
  const Vec3 n = way / distance;
  const double gap = least_along(n, s, is_triangle);
  if (gap > 0.5 * distance) return {n, gap, distance};
  Vec3 normal = cross(s.e, s.f);
  const double size = norm(normal);
  if (!(size > 0)) return {n, gap, distance};
  normal = (dot(normal, way) < 0 ? -1 : 1) / size * normal;
  const double across = least_along(normal, s, is_triangle);
  return across > gap ? Parting{normal, across, distance} : Parting{n, gap, distance};
}

double size_of_errors(const SliceErrors& off) {
  const Vec3 sum = off.base + off.e + off.f;
  return sum.x + sum.y + sum.z;
}

}  // namespace

std::array<double, 2> closest_of(const Slice& slice, bool is_triangle) {
  const auto& [p, e, f] = slice;
  const double ee = norm_squared(e), ff = norm_squared(f), ef = dot(e, f), pe = dot(p, e),
               pf = dot(p, f), area = ee * ff - ef * ef;
  const bool is_flat = !(area > 1e-14 * ee * ff);
  if (is_triangle) {
    const double u = pe * ff - pf * ef, v = pf * ee - pe * ef;
    if (!is_flat && u >= 0 && v >= 0 && u + v <= area) return {u / area, v / area};
    return closest_on_sides(p, e, f);
  }
  // two segments (Ericson 2005, §5.1.9): u on the lines, v for that u, u again for the clamped v
  const double u = is_flat ? 0 : clamped((pe * ff - pf * ef) / area);
  const double v = ff > 0 ? clamped((pf - u * ef) / ff) : 0;
  return {ee > 0 ? clamped((pe - v * ef) / ee) : 0, v};
}

Advance advance(const FeaturePath& path, double tolerance) {
  HAPTIC_ASSERT(!(tolerance < 0) && path.begin() <= path.end());
  double t = path.begin(), horizon = path.end() - t, near = tolerance;
  Slice here = path.first();
  const double rounding = 4 * size_of_errors(path.errors());
  for (int step = 0; step < kMostSteps; ++step) {
    const Parting parting = part(here, path.is_triangle());
    if (step == 0) near = std::min(near, 0.5 * parting.distance);
    if (parting.distance <= near) return {t, Advance::End::kNear};
    const double gap = parting.gap - rounding;
    if (!(gap > 0)) return {t, Advance::End::kUnknown};
    horizon = std::min(2 * horizon, path.end() - t);
    // shorten the step while the path bends by more than a quarter of the gap
    while (path.deviation(horizon) > 0.25 * gap && horizon > 0) horizon *= 0.5;
    if (!(horizon > 0)) return {t, Advance::End::kUnknown};
    const double bend = path.deviation(horizon);
    const bool is_last = t + horizon >= path.end();
    const Slice there = is_last ? path.last() : path.at(t + horizon);
    const double left = least_along(parting.n, there, path.is_triangle()) - rounding;
    if (left > bend) {
      if (is_last) return {path.end(), Advance::End::kApart};
      t += horizon;
      here = there;
      continue;
    }
    // to where the interpolation falls to half of `near`, but by at least a quarter of the room:
    // features that touched must be able to separate
    const double room = gap - bend;
    t += kShortOf * horizon * std::max(room - 0.5 * near, 0.25 * room) / (gap - left);
    here = path.at(t);
  }
  return {t, Advance::End::kUnknown};
}

}  // namespace haptic

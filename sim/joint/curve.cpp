// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/joint/curve.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kFiner = 16;    // chords for each of the points' own, for the length
constexpr int kNewtonSteps = 4;  // from the last step's length, a millimetre away at most

std::array<Spline, 3> splines_through(std::span<const Vec3> points,
                                      const std::vector<double>& lengths) {
  std::array<Spline, 3> splines;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const Vec3& p : points) values.push_back(p[k]);
    splines[static_cast<size_t>(k)] = build_spline(lengths, std::move(values));
  }
  return splines;
}

std::vector<double> chord_lengths(std::span<const Vec3> points) {
  std::vector<double> lengths{0};
  for (size_t i = 1; i < points.size(); ++i) {
    lengths.push_back(lengths.back() + norm(points[i] - points[i - 1]));
  }
  return lengths;
}

}  // namespace

Curve build_curve(std::span<const Vec3> points) {
  HAPTIC_ASSERT(points.size() >= 2);
  const std::vector<double> chords = chord_lengths(points);
  const std::array<Spline, 3> coarse = splines_through(points, chords);
  std::vector<Vec3> fine;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    for (size_t k = i == 0 ? 0 : 1; k <= kFiner; ++k) {
      const double share = static_cast<double>(k) / kFiner;
      const double u = (1 - share) * chords[i] + share * chords[i + 1];
      fine.push_back(
          {spline_at(coarse[0], u).y, spline_at(coarse[1], u).y, spline_at(coarse[2], u).y});
    }
  }
  const std::vector<double> lengths = chord_lengths(fine);
  return {splines_through(fine, lengths), lengths.back()};
}

CurvePoint curve_at(const Curve& curve, double length) {
  const double inside = std::clamp(length, 0.0, curve.length);
  CurvePoint point;
  for (int k = 0; k < 3; ++k) {
    const SplineValue value = spline_at(curve.by_length[static_cast<size_t>(k)], inside);
    point.p[k] = value.y;
    point.tangent[k] = value.first;
    point.curvature[k] = value.second;
  }
  point.tangent = normalized(point.tangent);
  point.p += (length - inside) * point.tangent;
  // of the tangent's derivative what turns it
  point.curvature -= dot(point.curvature, point.tangent) * point.tangent;
  return point;
}

double nearest_length(const Curve& curve, const Vec3& p, double near) {
  for (int i = 0; i < kNewtonSteps; ++i) {
    const CurvePoint at = curve_at(curve, near);
    const Vec3 away = p - at.p;
    // within half the radius of curvature the step is Newton's, farther out it is shorter
    const double bend = std::max(0.5, 1 - dot(away, at.curvature));
    near += dot(away, at.tangent) / bend;
  }
  return near;
}

}  // namespace haptic

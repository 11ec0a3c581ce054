// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "contact/bake/convex/growing_hull.h"
#include "proto/math/mat3.h"

namespace haptic {

/// Sum of squared distances to planes, each weighted by an area (Garland & Heckbert 1997):
/// E(p) = pᵀ A p − 2 bᵀ p + c [m⁴].
struct Quadric {
  Mat3 A{{{}, {}, {}}};
  Vec3 b;
  double c = 0;

  void add(const Plane& plane, double area) {
    const Vec3& n = plane.normal;
    for (int i = 0; i < 3; ++i) A.row[i] += area * n[i] * n;
    b += area * plane.offset * n;
    c += area * plane.offset * plane.offset;
  }
  void add(const Quadric& q) {
    A = A + q.A;
    b += q.b;
    c += q.c;
  }
  double area() const { return A.row[0].x + A.row[1].y + A.row[2].z; }
  /// Root mean square distance of p to the planes [m].
  double distance(const Vec3& p) const {
    return std::sqrt(std::max(dot(p, A * p) - 2 * dot(b, p) + c, 0.0) / area());
  }
};

/// The point that minimises E(p) + weight · trace(A) · |p − middle|²: where the planes leave no
/// choice, their best point, and along a flat part, or over detail that cancels, near the middle.
/// weight > 0.
inline Vec3 filtered_minimum(const Quadric& q, const Vec3& middle, double weight) {
  const double w = weight * q.area();
  Mat3 A = q.A;
  for (int i = 0; i < 3; ++i) A.row[i][i] += w;
  // relative to the middle: A d = b − (A − w I) middle; A is symmetric
  const Vec3 rest = q.b - q.A * middle;
  const Vec3 x = cross(A.row[1], A.row[2]), y = cross(A.row[2], A.row[0]);
  const double determinant = dot(A.row[0], x);
  if (!(determinant > 0)) return middle;
  const Vec3 z = cross(A.row[0], A.row[1]);
  return middle + 1 / determinant * (rest.x * x + rest.y * y + rest.z * z);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/math/vec3.h"

namespace haptic {

/// A convex polygon of at most so many corners; more are left out.
template <size_t kRoom>
struct ConvexPolygon {
  std::array<Vec3, kRoom> point;
  size_t n = 0;

  void add(const Vec3& p) {
    if (n < kRoom) point[n++] = p;
  }
  /// The part with wall·(p − from) ≥ −slack (Sutherland & Hodgman 1974).
  ConvexPolygon clipped(const Vec3& wall, const Vec3& from, double slack) const {
    ConvexPolygon kept;
    for (size_t i = 0; i < n; ++i) {
      const Vec3 &p = point[i], &q = point[i + 1 < n ? i + 1 : 0];
      const double at_p = dot(wall, p - from) + slack, at_q = dot(wall, q - from) + slack;
      if (at_p >= 0) kept.add(p);
      if ((at_p >= 0) != (at_q >= 0)) kept.add(p + at_p / (at_p - at_q) * (q - p));
    }
    return kept;
  }
};

}  // namespace haptic

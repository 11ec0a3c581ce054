// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "contact/bake/convex/growing_hull.h"

namespace haptic {

/// A convex polygon, and room for another while it is cut.
struct CutPolygon {
  std::vector<Vec3> p, other;

  /// Keeps the part with plane.above(p) < −margin. Whether there is any.
  bool cut(const Plane& plane, double margin) {
    other.clear();
    for (size_t i = 0; i < p.size(); ++i) {
      const Vec3 &a = p[i], &b = p[i + 1 < p.size() ? i + 1 : 0];
      const double of_a = plane.above(a) + margin, of_b = plane.above(b) + margin;
      if (of_a < 0) other.push_back(a);
      if ((of_a < 0) != (of_b < 0)) other.push_back(a + of_a / (of_a - of_b) * (b - a));
    }
    std::swap(p, other);
    return !p.empty();
  }
};

}  // namespace haptic

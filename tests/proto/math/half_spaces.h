// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "proto/math/project_point.h"

namespace haptic::test {

/// Nearest point to p with n_i·x ≥ d_i by trying every set of at most three planes.
inline Vec3 nearest_by_enumeration(const std::vector<HalfSpace>& h, const Vec3& p) {
  Vec3 best;
  double best_distance = std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3& x) {
    for (const auto& plane : h) {
      if (dot(plane.normal, x) < plane.offset - 1e-10) return;
    }
    if (norm(x - p) < best_distance) best = x, best_distance = norm(x - p);
  };
  offer(p);
  for (size_t i = 0; i < h.size(); ++i) {
    offer(p + (h[i].offset - dot(h[i].normal, p)) * h[i].normal);
    for (size_t j = i + 1; j < h.size(); ++j) {
      // on the line of two planes: from the point of it nearest to the origin
      const Vec3 &a = h[i].normal, &b = h[j].normal;
      const Vec3 along = cross(a, b);
      const double sine2 = norm_squared(along);
      if (sine2 < 1e-8) continue;
      const Vec3 on_line = cross(h[i].offset * b - h[j].offset * a, along) / sine2;
      offer(on_line + (dot(p - on_line, along) / sine2) * along);
      for (size_t k = j + 1; k < h.size(); ++k) {
        const Vec3& c = h[k].normal;
        const double volume = dot(a, cross(b, c));
        if (std::fabs(volume) < 1e-6) continue;
        offer((h[i].offset * cross(b, c) + h[j].offset * cross(c, a) + h[k].offset * cross(a, b)) /
              volume);
      }
    }
  }
  return best;
}

}  // namespace haptic::test

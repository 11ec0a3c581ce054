// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/vec3.h"

namespace haptic {

/// Whether a triangle meets a cube centred at the origin, border included; `half` is half its edge.
/// Separating axes of Akenine-Möller 2001, in double: rounding decides for a triangle that touches
/// the border, which callers cover by a slightly larger half.
inline bool triangle_meets_cube(const Corners& v, double half) {
  const auto apart = [](double p, double q, double r, double radius) {
    return std::min({p, q, r}) > radius || std::max({p, q, r}) < -radius;
  };
  for (int i = 0; i < 3; ++i) {
    if (apart(v[0][i], v[1][i], v[2][i], half)) return false;
  }
  const Vec3 n = cross(v[1] - v[0], v[2] - v[0]);
  const double reach = half * (std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z));
  if (std::fabs(dot(n, v[0])) > reach) return false;
  for (size_t i = 0; i < 3; ++i) {
    const Vec3 e = v[(i + 1) % 3] - v[i];
    for (const Vec3& axis : {Vec3{0, e.z, -e.y}, Vec3{-e.z, 0, e.x}, Vec3{e.y, -e.x, 0}}) {
      const double radius = half * (std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z));
      if (apart(dot(axis, v[0]), dot(axis, v[1]), dot(axis, v[2]), radius)) return false;
    }
  }
  return true;
}

}  // namespace haptic

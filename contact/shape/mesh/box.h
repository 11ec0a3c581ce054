// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// An axis-aligned box [m].
struct Box {
  Vec3 lower, upper;

  Vec3 size() const { return upper - lower; }
  bool overlaps(const Box& b) const {
    return lower.x <= b.upper.x && b.lower.x <= upper.x && lower.y <= b.upper.y &&
           b.lower.y <= upper.y && lower.z <= b.upper.z && b.lower.z <= upper.z;
  }
  void add(const Vec3& p) {
    lower = component_min(lower, p);
    upper = component_max(upper, p);
  }
  void add(const Box& b) { add(b.lower), add(b.upper); }
};

/// The box around points, of which there must be one.
template <class Points>
Box box_around(const Points& points) {
  Box box{points[0], points[0]};
  for (const Vec3& p : points) box.add(p);
  return box;
}

/// The longest of three sides, and the axis that it lies along; of equal ones the first.
inline double longest_of(const Vec3& sides) {
  return std::max({sides.x, sides.y, sides.z});
}
inline int longest_axis(const Vec3& sides) {
  return sides.x >= sides.y && sides.x >= sides.z ? 0 : sides.y >= sides.z ? 1 : 2;
}

/// The largest coordinate by its size: rounding errors are proportional to it.
inline double largest_coordinate(const Vec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}
inline double largest_coordinate(const TriangleMesh& mesh) {
  return std::max(largest_coordinate(mesh.lower), largest_coordinate(mesh.upper));
}

}  // namespace haptic

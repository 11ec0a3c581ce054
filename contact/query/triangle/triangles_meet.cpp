// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/triangles_meet.h"

#include "contact/query/triangle/orientation.h"

namespace haptic {
namespace {

using Signs = std::array<int, 3>;

/// On which side of the plane of `face` the corners lie.
Signs sides_of(const Corners& face, const Corners& corners) {
  Signs signs;
  for (size_t i = 0; i < 3; ++i) signs[i] = orientation(face[0], face[1], face[2], corners[i]);
  return signs;
}

bool all_on_one_side(const Signs& s) {
  return s[0] != 0 && s[0] == s[1] && s[1] == s[2];
}
bool all_in_plane(const Signs& s) {
  return s[0] == 0 && s[1] == 0 && s[2] == 0;
}

/// Whether the line from p to q, not in the plane of the face, passes inside its outline or on it.
bool passes_inside(const Vec3& p, const Vec3& q, const Corners& face) {
  bool left = false, right = false;
  for (size_t i = 0; i < 3; ++i) {
    const int side = orientation(p, q, face[i], face[(i + 1) % 3]);
    left = left || side > 0;
    right = right || side < 0;
  }
  return !(left && right);
}

/// Whether an edge of `corners` meets the face; `sides` are sides_of(face, corners). Edges in the
/// plane of the face are skipped: where they meet it, an adjacent edge or one of the face does.
bool edge_meets(const Corners& corners, const Signs& sides, const Corners& face) {
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3;
    if (sides[i] * sides[j] > 0 || (sides[i] == 0 && sides[j] == 0)) continue;
    if (passes_inside(corners[i], corners[j], face)) return true;
  }
  return false;
}

using Flat = std::array<Point2, 3>;

Flat without_axis(const Corners& corners, int axis) {
  Flat flat;
  for (size_t i = 0; i < 3; ++i) {
    flat[i] = {corners[i][(axis + 1) % 3], corners[i][(axis + 2) % 3]};
  }
  return flat;
}

/// Whether an edge of a, whose orientation is `turn`, has all of b on its outer side.
bool edge_separates(const Flat& a, int turn, const Flat& b) {
  for (size_t i = 0; i < 3; ++i) {
    bool all_outside = true;
    for (const Point2& p : b) {
      all_outside = all_outside && turn * orientation(a[i], a[(i + 1) % 3], p) < 0;
    }
    if (all_outside) return true;
  }
  return false;
}

/// Coplanar triangles: projected along an axis that degenerates neither, they meet if no edge
/// separates them.
bool meet_in_plane(const Corners& a, const Corners& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const Flat flat_a = without_axis(a, axis), flat_b = without_axis(b, axis);
    const int turn_a = orientation(flat_a[0], flat_a[1], flat_a[2]);
    const int turn_b = orientation(flat_b[0], flat_b[1], flat_b[2]);
    if (turn_a == 0 || turn_b == 0) continue;
    return !edge_separates(flat_a, turn_a, flat_b) && !edge_separates(flat_b, turn_b, flat_a);
  }
  return false;
}

}  // namespace

bool triangles_meet(const Corners& a, const Corners& b) {
  const Signs a_sides = sides_of(b, a);
  if (all_on_one_side(a_sides)) return false;
  const Signs b_sides = sides_of(a, b);
  if (all_on_one_side(b_sides)) return false;
  if (all_in_plane(a_sides) || all_in_plane(b_sides)) return meet_in_plane(a, b);
  return edge_meets(a, a_sides, b) || edge_meets(b, b_sides, a);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/patch_tests.h"

namespace haptic {

/// A sphere on a straight way, made ready for the tests.
struct WayProbe {
  /// `furthest`: largest coordinate of the way and of the mesh.
  WayProbe(const Vec3& from_O, const Vec3& d_O, double radius, double furthest);

  Vec3 from_O;
  std::array<float, 3> from, d;  // in floats
  float length, radius;          // of the way and of the sphere [m]
  float slack;                   // more than the roundings of a distance [m]
};

/// Patches that the sphere may come to touch on its way, and triangles of the leaf: all but those
/// that a plane across some direction keeps off. Keep too many, never too few.
LaneSet patches_on_way(const PatchNode& node, const WayProbe& way);
LaneSet triangles_on_way(const PatchLeaf& leaf, const WayProbe& way);

}  // namespace haptic

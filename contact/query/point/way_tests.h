// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/patch_tests.h"

namespace haptic {

/// A sphere on a straight path, prepared for the tests.
struct WayProbe {
  /// `furthest`: largest coordinate of the path and of the mesh [m].
  WayProbe(const Vec3& from_O, const Vec3& d_O, double radius, double furthest);

  Vec3 from_O;
  std::array<float, 3> from, d;  // start and displacement [m]
  float length, radius;          // of the path and of the sphere [m]
  float slack;                   // bound of the rounding of a distance [m]
};

/// Patches, and triangles of a leaf, that the sphere may touch along its path: those that no plane
/// across some direction separates from it. Conservative: keep too many, never too few.
LaneSet patches_on_way(const PatchNode& node, const WayProbe& way);
LaneSet triangles_on_way(const PatchLeaf& leaf, const WayProbe& way);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/convex/gauss_overlay.h"

namespace haptic {

/// A point on each hull, both in A.
struct TouchingPoints {
  Vec3 point_a, point_b;
};

/// Where the features of an overlay vertex would touch after b has moved by depth · n: point_a −
/// point_b = depth · n. Of edges or faces that touch along more than a point, the middle of it.
TouchingPoints touching_points(const HullPair& pair, const OverlayVertex& at);

}  // namespace haptic

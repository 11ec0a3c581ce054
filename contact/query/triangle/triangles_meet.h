// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/math/vec3.h"

namespace haptic {

using Corners = std::array<Vec3, 3>;  // of a triangle, counter-clockwise seen from outside

/// Whether two triangles have a point in common, borders included: touching at a corner or along an
/// edge counts, and so does overlapping in one plane. Exact for the doubles given (orientation.h).
/// A triangle without area meets nothing: its neighbours do.
///
/// As Guigue & Devillers 2003, by signs of determinants alone; deviation: instead of ordering the
/// ends of two intervals on the line common to both planes, each edge that reaches the plane of
/// the other triangle is asked whether it passes inside its outline.
bool triangles_meet(const Corners& a, const Corners& b);

}  // namespace haptic

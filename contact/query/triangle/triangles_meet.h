// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/vec3.h"

namespace haptic {

/// Whether two triangles have a common point, borders included: touching at a corner or along an
/// edge counts, and so does overlapping in one plane. Exact for the doubles given (orientation.h).
/// A triangle without area meets nothing: its neighbours do.
///
/// By signs of determinants alone as in Guigue & Devillers 2003; but instead of ordering two
/// intervals on the common line of both planes, each edge that reaches the other plane is tested
/// for passing inside the outline.
bool triangles_meet(const Corners& a, const Corners& b);

}  // namespace haptic

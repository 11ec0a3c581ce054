// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Radius [m] around point_O within which the plane of `triangle` approximates the surface:
/// distance to the nearest border or convex edge behind which the surface turns away by more than
/// 25°, found by a walk over at most 32 triangles, within [kMinExtent, kMaxExtent]. Concave edges
/// do not limit it: behind them the plane lies inside the object.
double plane_extent(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O);

inline constexpr double kMinExtent = 0.5e-3;  // [m]; way of a hand at 0.2 m/s in 2.5 ms
inline constexpr double kMaxExtent = 20e-3;   // [m]; a hand at 0.5 m/s with contact at 25 Hz

}  // namespace haptic

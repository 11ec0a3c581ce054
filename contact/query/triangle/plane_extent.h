// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Radius around point_O within which the plane of `triangle` stands in for the surface: distance
/// to the nearest border or convex edge behind which the surface turns away by more than 25°, found
/// by walking over at most 32 triangles, within [kMinExtent, kMaxExtent]. Concave edges do not
/// limit a plane: behind them it lies inside the object.
double plane_extent(const TriangleMesh& mesh, uint32_t triangle, const Vec3& point_O);

inline constexpr double kMinExtent = 0.5e-3;  // a hand at 0.2 m/s between two contact steps [m]
inline constexpr double kMaxExtent = 20e-3;   // a hand at 0.5 m/s with contact at 25 Hz [m]

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "contact/shape/mesh/primitives.h"

namespace haptic {

/// Resolution of a vessel: a cap of `rings` rings, ring k with 6k vertices, then `rows` rows of
/// 6·rings vertices.
struct VesselGrid {
  uint32_t rings = 40, rows = 20;
};

/// A closed surface with the topology of a sphere. Its cap is a disc of even triangles about a pole
/// (ring 0); the rings and, after them, the rows (number rings + 1, rings + 2, …) run once around
/// the z axis, and a fan closes the last one at `end`. position(ring, θ) gives the vertex at the
/// angle θ [rad] about z. Faces point up on the cap where the rings grow outwards (or down, with
/// `faces_down`). 6·rings² + 12·rings·rows + 6·rings triangles.
using VesselAt = std::function<Vec3(uint32_t ring, double theta)>;
Soup make_vessel(const VesselAt& position, const Vec3& end, const VesselGrid& grid,
                 bool faces_down);

}  // namespace haptic

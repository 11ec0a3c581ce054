// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// Every triangle with a point nearer than radius, as its closest point, unordered. Writes at most
/// out.size() and returns how many there were (more than out.size(): truncated).
size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

/// Those of triangles_within that touch a point of the surface locally nearest to p_O and seen from
/// the front, and a few others: all of them around each such point. How many there are depends on
/// the shape of the surface, hardly on how finely it is meshed: patches that do not face p_O are
/// left out as a whole.
size_t triangles_facing(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/shape/baked/mesh_shape.h"

namespace haptic {

/// Every triangle with a point nearer than radius [m], as its closest point, unordered. Writes at
/// most out.size() and returns how many there are (more than out.size(): truncated).
size_t triangles_within(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

/// The triangles of triangles_within that touch a local minimum of the distance to p_O that is seen
/// from the front, and a few others; all triangles around each such point. Their number depends on
/// the shape of the surface and hardly on the resolution of the mesh: patches that do not face p_O
/// are pruned.
size_t triangles_facing(const MeshShape& shape, const Vec3& p_O, double radius,
                        std::span<ClosestPoint> out);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "contact/query/triangle/triangles_meet.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/math/pose.h"

namespace haptic {

/// A triangle of A and one of B.
struct TrianglePair {
  uint32_t a = 0, b = 0;

  constexpr auto operator<=>(const TrianglePair&) const = default;
};

/// All pairs of triangles of two meshes that meet (triangles_meet: touching and coplanar count),
/// with B at X_AB in A: descends both trees at once, the larger box opened first (Gottschalk, Lin,
/// Manocha 1996). Exact for the corners of B as corners_of rounds them. Writes at most out.size()
/// pairs, in tree order, and returns how many there are. None for a pose that is not finite.
size_t triangle_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                      std::span<TrianglePair> out);

/// Does the same in bounded time: returns null after `most_boxes` pairs of boxes.
std::optional<size_t> triangle_pairs_within(const MeshShape& shape_A, const MeshShape& shape_B,
                                            const Pose& X_AB, std::span<TrianglePair> out,
                                            size_t most_boxes);

}  // namespace haptic

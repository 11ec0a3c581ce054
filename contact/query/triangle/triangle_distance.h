// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/query/triangle/distance_batch.h"
#include "contact/query/triangle/triangles_meet.h"
#include "proto/math/pose.h"

namespace haptic {

/// The part of a triangle that carries a closest point: corner i, side i (from corner i to (i + 1)
/// % 3), or the face.
enum class TrianglePart : uint8_t { kCorner0, kCorner1, kCorner2, kSide0, kSide1, kSide2, kFace };

/// Distance and closest points of two triangles. If they meet, the distance is 0, and the points
/// are the closest of their borders and corners, not a common point.
struct TriangleDistance {
  double distance = 0;  // [m]
  Vec3 point_a, point_b;
  TrianglePart part_a = TrianglePart::kFace, part_b = TrianglePart::kFace;
};

/// Distance of two triangles: the least of nine pairs of sides and six of a corner and a face, 0 if
/// they meet (triangles_meet, exact). Closest points of disjoint convex bodies define a separating
/// plane, so those found usually prove that the triangles are apart; only otherwise is the exact
/// test needed. Accurate to 1e-8 of the size of the triangles where nearly parallel sides nearly
/// touch, else to a few roundings. A triangle without area is its border.
TriangleDistance triangle_distance(const Corners& a, const Corners& b);

/// The distances of all nine pairs of sides, and of each corner that lies over the other face.
/// Returns how many. Does not test whether the triangles meet.
inline constexpr size_t kTrianglePartPairs = 15;
size_t distances_of_parts(const Corners& a, const Corners& b,
                          std::array<TriangleDistance, kTrianglePartPairs>& out);

/// Computes the distance of each pair with B at X_AB in A: bit-identical to triangle_distance with
/// the corners moved to A (X_AB * p). Eight at a time with AVX-512, four with AVX2.
void measure(const Pose& X_AB, DistanceBatch& batch);

/// Distance, closest points and parts of pair i, in A.
TriangleDistance measured(const DistanceBatch& batch, size_t i);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/query/triangle/triangles_meet.h"
#include "proto/math/pose.h"

namespace haptic {

/// What of a triangle carries a closest point: corner i, side i (from corner i to (i + 1) % 3), or
/// the face.
enum class TrianglePart : uint8_t { kCorner0, kCorner1, kCorner2, kSide0, kSide1, kSide2, kFace };

/// How far two triangles are apart, and where. Where they meet the distance is 0 and the points are
/// the closest of their borders and corners, no common point.
struct TriangleDistance {
  double distance = 0;  // [m]
  Vec3 point_a, point_b;
  TrianglePart part_a = TrianglePart::kFace, part_b = TrianglePart::kFace;
};

/// Distance of two triangles: the least of nine pairs of sides and six of a corner and a face, 0
/// where they meet (triangles_meet, exact). As the closest points of disjoint convex bodies lie on
/// planes that separate them, those found show by themselves that the triangles are apart, and
/// only where they do not is the exact test asked. To 1e-8 of the size of the triangles where they
/// nearly touch on nearly parallel sides, else to a few roundings. A triangle without area is its
/// border.
TriangleDistance triangle_distance(const Corners& a, const Corners& b);

/// The same of each pair of parts by itself: nine of sides, and of corners those that are over the
/// other face. Returns how many there are. Meeting is not asked.
inline constexpr size_t kTrianglePartPairs = 15;
size_t distances_of_parts(const Corners& a, const Corners& b,
                          std::array<TriangleDistance, kTrianglePartPairs>& out);

/// Many pairs of triangles side by side.
struct DistanceBatch {
  static constexpr size_t kRoom = 64;
  using Lanes = std::array<double, kRoom>;
  size_t n = 0;
  std::array<Lanes, 9> a{}, b{};  // corners, coordinate after coordinate, those of b in B
  // what was found; then the corners of b are in A. The way goes from a to b, in A; the gap is how
  // far the planes across it through both triangles are apart, times its length
  Lanes distance_squared{}, gap{}, parts{}, along_a{}, along_b{};
  std::array<Lanes, 3> way{};

  /// There must be room.
  void add(const Corners& corners_A, const Corners& corners_B);
  Corners corners_a(size_t i) const;
  Corners corners_b(size_t i) const;
};

/// Fills in the distance of each pair with B at X_AB in A: what triangle_distance says of the
/// corners in A (X_AB * p), to the bit. Four at a time where the processor has AVX2.
void measure(const Pose& X_AB, DistanceBatch& batch);

/// Distance, places and parts of one that was measured, in A.
TriangleDistance measured(const DistanceBatch& batch, size_t i);

}  // namespace haptic

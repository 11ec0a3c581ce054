// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "contact/query/box/obb_overlap.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "contact/query/triangle/triangle_distance.h"

namespace haptic {

/// A triangle of A and one of B that are near, and how they lie, in A.
struct NearPair {
  TrianglePair triangles;
  TriangleDistance at;
};

/// All pairs of triangles of two meshes no further apart than the band [m], with B at X_AB in A:
/// both trees at once, the larger box opened first. Writes at most out.size(), in the order of the
/// trees, and returns how many there are. None for a pose or band that is not finite, or a band
/// below 0.
size_t near_pairs(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB, double band,
                  std::span<NearPair> out);

/// Whether there is any; ends with the first.
bool any_near_pair(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                   double band);

/// The same with an end: kUnknown once so many pairs of boxes have been compared.
enum class AnyNear { kNone, kFound, kUnknown };
AnyNear find_near_pair(const MeshShape& shape_A, const MeshShape& shape_B, const Pose& X_AB,
                       double band, size_t most_boxes, TrianglePair& found);

}  // namespace haptic

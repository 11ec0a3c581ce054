// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "contact/query/point/triangles_within.h"

namespace haptic {

/// A feature that the point may run into next: a local minimum of the distance.
struct NearFeature {
  ClosestPoint closest;
  Vec3 normal_O;  // unit, from the surface to the point
};

inline constexpr size_t kMaxNearTriangles = 256;  // of one query

/// Buffers of one query, so that a step allocates nothing.
struct NearScratch {
  std::array<ClosestPoint, kMaxNearTriangles> triangles;
  std::array<NearFeature, kMaxNearTriangles> features;
};

struct NearResult {
  size_t count = 0;
  bool truncated = false;  // too many triangles: any feature may be missing
  size_t left_out = 0;     // the farthest features, for lack of room
};

/// Local minima of the distance from p_O to the mesh within radius [m], nearest first: faces seen
/// from the front, and edges and vertices whose normal cone contains p_O (all triangles around them
/// agree that they are nearest). Their planes are those that may become active; a face beyond a
/// convex edge is not among them.
NearResult near_features(const MeshShape& shape, const Vec3& p_O, double radius,
                         NearScratch& scratch, std::span<NearFeature> out);

}  // namespace haptic

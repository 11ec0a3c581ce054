// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/shape/convex/hull.h"
#include "proto/math/mat3.h"
#include "proto/math/pose.h"

namespace haptic {

enum class HullPart : uint32_t { kVertex, kEdge, kFace };

/// A vertex, an edge (as one of its half-edges) or a face of a hull, with its index there.
struct HullFeature {
  HullPart kind = HullPart::kVertex;
  uint32_t index = 0;

  bool operator==(const HullFeature&) const = default;
};

/// Where two hulls are nearest to each other, or deepest in each other.
struct HullTouch {
  Vec3 normal_A;          // unit, from a to b
  Vec3 point_a, point_b;  // on each hull, both in A [m]
  HullFeature feature_a, feature_b;
};

/// The state of a pair of hulls between queries: 56 bytes, trivially copyable; all zero for a new
/// pair.
struct ConvexPairState {
  HullFeature feature_a, feature_b;  // of the last answer
  Vec3 normal_A;                     // of the last answer; zero: none yet
  uint32_t overlapping = 0;          // 1: the last answer was a depth
  uint32_t age = 0;                  // overlapping queries since the last look elsewhere

  void keep(const HullTouch& last, bool is_depth) {
    feature_a = last.feature_a, feature_b = last.feature_b, normal_A = last.normal_A;
    overlapping = is_depth;
  }
};

/// Two hulls at one relative pose; both must outlive it.
struct HullPair {
  const Hull& a;
  const Hull& b;
  Mat3 R_AB;
  Vec3 p_AB;

  HullPair(const Hull& hull_a, const Hull& hull_b, const Pose& X_AB)
      : a(hull_a), b(hull_b), R_AB(to_matrix(X_AB.q)), p_AB(X_AB.p) {}

  /// Side 0 is a, side 1 is b.
  const Hull& hull(int side) const { return side == 0 ? a : b; }
  Vec3 vertex(int side, uint32_t i) const { return side == 0 ? vertex_a(i) : vertex_b(i); }
  Vec3 vertex_a(uint32_t i) const { return a.vertices[i]; }
  Vec3 vertex_b(uint32_t i) const { return R_AB * b.vertices[i] + p_AB; }  // in A
};

/// Returns true if the hull has such a feature.
bool is_feature(const Hull& hull, const HullFeature& feature);

/// A vertex of the feature.
uint32_t corner_of(const Hull& hull, const HullFeature& feature);

/// Returns true if a feature lies on the surface of the object: a face that is not virtual, or an
/// edge or vertex of such a face.
bool is_real(const Hull& hull, const HullFeature& feature);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "proto/math/spatial.h"

namespace haptic {

inline constexpr size_t kMostClusters = 64;  // of one object, as many as a set has contacts

/// One of many touching points: a spring along the normal.
struct PointPush {
  Vec3 point_O;
  Vec3 normal_O;         // unit, from object to tool
  double depth = 0;      // > 0 [m]; ≤ 0: approaching
  double stiffness = 0;  // [N/m]
  double count = 1;      // number of points that it represents
};

/// One spring that represents many: its depth is such that stiffness · depth = |sum of the forces|,
/// its stiffness and count are the sums over its points.
struct PushCluster : PointPush {
  double bulge = 0;  // how much its normals diverge, −Σ w n·Δp / Σ w Δp²; of a ball of the tool
                     // 1/radius; 0: flat, or unknown [1/m]
};

/// Wrench of all springs about a point, and its linearisation for small motions of the tool.
struct LinearPush {
  Wrench F0_O;
  Mat6 K;  // −Σ k w wᵀ, w = (n, r × n): symmetric, negative semidefinite
};

struct ClusterOptions {
  double radius = 5e-3;          // points farther than this from all clusters begin a new one [m]
  double least_agreement = 0.5;  // least cosine between a point's normal and its cluster's:
                                 // opposite sides of a slot must not cancel
  double tolerance = 0;          // distance from which on approaching points are reported [m]
};

/// The clusters of one object in the last frame, where those of the next begin.
struct ClusterMemory {
  struct Centre {
    Vec3 point_O, normal_O;
  };
  struct Kind {
    std::array<Centre, kMostClusters> centres;
    size_t size = 0;
  };
  Kind pushing, approaching;
};

/// F0 = Σ k d (n, r × n) over points with d > 0, about `about_O`.
LinearPush sum_pushes(std::span<const PointPush> pushes, const Vec3& about_O);

/// Lets pushes share their stiffness from `sharing` on: each has k · min(1, sharing/N), where
/// N = (Σ d)² / Σ d² is how many push equally hard. A push that begins has no weight in N, and the
/// sum of the forces of a face does not grow with the number of its corners (McNeely, Puterbaugh,
/// Troy 1999 share by their number instead).
void share_stiffness(std::span<PointPush> pushes, double stiffness, double sharing);

/// Weighted K-means in (position, normal) space, at the distance
///   D² = |p − c|² + λ² |n − m|²,  λ² = radius² / (2 − 2 least_agreement),
/// so that D ≤ radius implies that the normals agree. Points that share a cell, of radius/4 and of
/// alike normals, are one, with their weight and their sums; cells double in width until there are
/// no more than 512, so that most passes see few. It begins with the
/// centres of the last frame, merges those nearer than half the radius, and while a point is
/// farther than the radius from all, the farthest becomes a centre; then each centre moves to the
/// weighted mean of its points, and points are assigned once more. With no more room a point goes
/// to the nearest centre whose normal agrees; without one it is left out. Weights are k (depth +
/// tolerance), with tolerance 0 for points that push: a point enters with weight zero among those
/// that push and among those that approach, which have clusters of their own and come after. A
/// cluster lies at Σ w p/Σ w, with normal Σ w n; it pushes by the sum of the forces of its points,
/// whichever these are, and if it approaches its depth is that of the nearest. The numbering of the
/// points does not matter. Returns the number of clusters. Source: Otaduy & Lin 2006; there a fixed
/// number of clusters in position alone, which lets opposite walls cancel. Farthest-point seeds:
/// Gonzalez 1985.
size_t cluster_pushes(std::span<const PointPush> pushes, const ClusterOptions& options,
                      ClusterMemory& memory, std::span<PushCluster> clusters);

}  // namespace haptic

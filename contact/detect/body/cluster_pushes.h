// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "proto/math/spatial.h"

namespace haptic {

/// One of many touching points: a spring along the normal.
struct PointPush {
  Vec3 point_O;
  Vec3 normal_O;         // unit, from object to tool
  double depth = 0;      // > 0 [m]; ≤ 0: approaching
  double stiffness = 0;  // [N/m]
  double count = 1;      // number of points that it represents
};

/// One spring that represents many.
struct PushCluster {
  Vec3 point_O;
  Vec3 normal_O;
  double depth = 0;      // such that stiffness · depth = |sum of the forces| [m]
  double stiffness = 0;  // sum over its points [N/m]
  uint32_t count = 0;
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
};

/// F0 = Σ k d (n, r × n) over points with d > 0, about `about_O`.
LinearPush sum_pushes(std::span<const PointPush> pushes, const Vec3& about_O);

/// Clusters the points by distance and normal, each cluster led by its first point; without room
/// for more clusters, points go to the best-fitting one. Weighted by force, or by nearness if all
/// approach (Kim, Otaduy, Lin, Manocha 2003; normals after Otaduy & Lin 2006, corrected: they must
/// agree). Approaching points have clusters of their own. A point next to one clustered shortly
/// before, with nearly the same normal, joins its cluster: most points of a shell in Morton order
/// do. Returns the number of clusters.
size_t cluster_pushes(std::span<const PointPush> pushes, const ClusterOptions& options,
                      std::span<PushCluster> clusters);

}  // namespace haptic

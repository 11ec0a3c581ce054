// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "proto/math/spatial.h"

namespace haptic {

/// One of many points that touch: a spring along the normal.
struct PointPush {
  Vec3 point_O;
  Vec3 normal_O;         // unit, from object to tool
  double depth = 0;      // > 0 [m]; < 0: it approaches
  double stiffness = 0;  // [N/m]
  double count = 1;      // of points that it stands for
};

/// A few springs that stand for many.
struct PushCluster {
  Vec3 point_O;
  Vec3 normal_O;
  double depth = 0;      // such that stiffness · depth is the length of the sum of the forces [m]
  double stiffness = 0;  // sum of those of its points [N/m]
  uint32_t count = 0;
};

/// Wrench of all springs about a point, and its linearisation for small motions of the tool.
struct LinearPush {
  Wrench F0_O;
  Mat6 K;  // −Σ k w wᵀ, w = (n, r × n): symmetric, never positive
};

struct ClusterOptions {
  double radius = 5e-3;          // points further from all clusters begin one of their own [m]
  double least_agreement = 0.5;  // cosine between a point's normal and its cluster's: opposite
                                 // sides of a slot must not cancel
};

/// F0 = Σ k d (n, r × n) over points with d > 0, about `about_O`.
LinearPush sum_pushes(std::span<const PointPush> pushes, const Vec3& about_O);

/// Sorts the points into clusters by distance and by normal, each led by its first point; once
/// there are as many as there is room for, into the one that fits best. Weighted by the force, or
/// where all approach by nearness (Kim, Otaduy, Lin, Manocha 2003; normals after Otaduy & Lin 2006
/// with the mend that they must agree). Approaching points have clusters of their own. A point next
/// to one that was sorted just before, with nearly its normal, goes where that one went: of a shell
/// in Morton order most do, and few are compared with all clusters. Returns how many there are.
size_t cluster_pushes(std::span<const PointPush> pushes, const ClusterOptions& options,
                      std::span<PushCluster> clusters);

}  // namespace haptic

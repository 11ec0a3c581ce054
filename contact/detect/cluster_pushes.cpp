// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/cluster_pushes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr size_t kMostClusters = 64;
constexpr double kNextTo = 0.25;      // of the radius
constexpr double kSameNormal = 0.95;  // cosine
constexpr double kFloor = 1e-9;  // weight of a point that just touches, so that it has a place [m]

/// What is summed while points come in.
struct Gathering {
  Vec3 leader_W, leader_normal_W;
  Vec3 weighted_point_W, weighted_normal_W;
  double weight = 0;
  bool approaches = false;
};

/// The last few points that were compared with all clusters, and where they went.
struct Recent {
  struct Place {
    Vec3 point_W, normal_W;
    size_t cluster = 0;
  };
  std::array<Place, 4> places;
  size_t n = 0;

  void add(const PointPush& push, size_t cluster) {
    places[n++ % places.size()] = {push.point_W, push.normal_W, cluster};
  }
};

/// A force where it pushes, else how near it is.
double weight_of(const PointPush& push) {
  return push.depth > 0 ? push.stiffness * (push.depth + kFloor)
                        : push.stiffness / (kFloor - push.depth);
}

/// The cluster a push belongs to; n where it begins one.
size_t fitting(const PointPush& push, const ClusterOptions& options,
               std::span<const Gathering> gatherings, bool has_room) {
  size_t best = gatherings.size();
  double best_misfit = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < gatherings.size(); ++i) {
    const Gathering& g = gatherings[i];
    if (g.approaches != (push.depth <= 0)) continue;
    const double away = norm(push.point_W - g.leader_W);
    const double agreement = dot(push.normal_W, g.leader_normal_W);
    const bool fits = away <= options.radius && agreement >= options.least_agreement;
    if (has_room && !fits) continue;
    const double misfit = away + options.radius * (1 - agreement);
    if (misfit < best_misfit) best = i, best_misfit = misfit;
  }
  return best;
}

/// The cluster of a neighbour that was sorted just before; `none` where there is none.
size_t cluster_next_to(const PointPush& push, const ClusterOptions& options, const Recent& recent,
                       size_t none) {
  const double near = kNextTo * options.radius;
  for (size_t i = 0; i < std::min(recent.n, recent.places.size()); ++i) {
    const Recent::Place& place = recent.places[i];
    if (norm_squared(push.point_W - place.point_W) <= near * near &&
        dot(push.normal_W, place.normal_W) >= kSameNormal) {
      return place.cluster;
    }
  }
  return none;
}

void gather(const PointPush& push, Gathering& gathering, PushCluster& cluster) {
  const double weight = weight_of(push);
  gathering.weighted_point_W += weight * push.point_W;
  gathering.weighted_normal_W += weight * push.normal_W;
  gathering.weight += weight;
  cluster.stiffness += push.stiffness;
  ++cluster.count;
  // of approaching points the nearest
  if (push.depth > 0) return;
  cluster.depth = cluster.count == 1 ? push.depth : std::max(cluster.depth, push.depth);
}

}  // namespace

LinearPush sum_pushes(std::span<const PointPush> pushes, const Vec3& about_W) {
  LinearPush sum;
  for (const PointPush& push : pushes) {
    if (!(push.depth > 0)) continue;
    const Wrench unit{push.normal_W, cross(push.point_W - about_W, push.normal_W)};
    sum.F0_W = sum.F0_W + (push.stiffness * push.depth) * unit;
    const std::array<double, 6> w = components(unit.f, unit.t);
    for (size_t i = 0; i < 6; ++i) {
      const double less = push.stiffness * w[i];
      for (size_t j = i; j < 6; ++j) sum.K(i, j) -= less * w[j];
    }
  }
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < i; ++j) sum.K(i, j) = sum.K(j, i);
  }
  return sum;
}

size_t cluster_pushes(std::span<const PointPush> pushes, const ClusterOptions& options,
                      std::span<PushCluster> clusters) {
  std::array<Gathering, kMostClusters> gatherings;
  const size_t room = std::min(clusters.size(), gatherings.size());
  size_t n = 0;
  // what pushes comes first, and never goes without for what approaches
  for (const bool approaches : {false, true}) {
    Recent recent;
    for (const PointPush& push : pushes) {
      if ((push.depth <= 0) != approaches) continue;
      size_t i = cluster_next_to(push, options, recent, room);
      if (i < room) {
        gather(push, gatherings[i], clusters[i]);
        continue;
      }
      i = fitting(push, options, {gatherings.data(), n}, n < room);
      if (i == n && n == room) continue;
      recent.add(push, i);
      if (i == n) {
        gatherings[n] = {push.point_W, push.normal_W, {}, {}, 0, approaches};
        clusters[n++] = {};
      }
      gather(push, gatherings[i], clusters[i]);
    }
  }
  for (size_t i = 0; i < n; ++i) {
    const Gathering& g = gatherings[i];
    clusters[i].point_W = g.weighted_point_W / g.weight;
    clusters[i].normal_W = normalized(g.weighted_normal_W);
    if (!g.approaches) {
      clusters[i].depth = std::max(norm(g.weighted_normal_W) / clusters[i].stiffness - kFloor, 0.0);
    }
  }
  return n;
}

}  // namespace haptic

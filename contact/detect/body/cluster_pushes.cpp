// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/cluster_pushes.h"

#include <algorithm>
#include <array>
#include <limits>

#include "contact/query/simd/lanes.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr size_t kMostClusters = 64;  // of one object
constexpr double kNextTo = 0.5;       // share of the radius within which two points are neighbours
constexpr double kSameNormal = 0.95;  // least cosine between the normals of neighbours
constexpr double kFloor = 1e-9;  // [m]; added to depths: a point that just touches has a weight

/// Running sums of a cluster.
struct Gathering {
  Vec3 weighted_point_O, weighted_normal_O;
  double weight = 0;
};

/// The last few points that were compared with all clusters, and their clusters.
struct Recent {
  struct Place {
    Vec3 point_O, normal_O;
    size_t cluster = 0;
  };
  std::array<Place, 4> places;
  size_t n = 0;

  void add(const PointPush& push, size_t cluster) {
    places[n++ % places.size()] = {push.point_O, push.normal_O, cluster};
  }
};

/// The force of a push; of approaching points, their nearness.
double weight_of(const PointPush& push) {
  return push.depth > 0 ? push.stiffness * (push.depth + kFloor)
                        : push.stiffness / (kFloor - push.depth);
}

/// The first points of the clusters, four per block: comparing with them takes most of the time.
class Leaders {
 public:
  void add(const PointPush& push) {
    HAPTIC_ASSERT(n_ < kMostClusters);
    const std::array own = in_floats(push);
    for (size_t k = 0; k < own.size(); ++k) blocks_[n_ / 4][k][n_ % 4] = own[k];
    ++n_;
  }

  /// The cluster that a push fits best: the least |p − p'|² + radius² |n − n'|², with must_fit only
  /// among those within the radius whose normals agree. kMostClusters: none.
  size_t fitting(const PointPush& push, const ClusterOptions& options, bool must_fit) const {
    const auto square = static_cast<float>(options.radius * options.radius),
               least = static_cast<float>(options.least_agreement);
    const auto [x, y, z, nx, ny, nz] = in_floats(push);
    Lanes best = kFar;
    IntLanes at = {kNone, kNone, kNone, kNone};
    for (size_t i = 0; 4 * i < n_; ++i) {
      const auto& [px, py, pz, mx, my, mz] = blocks_[i];
      const Lanes dx = px - x, dy = py - y, dz = pz - z;
      const Lanes away = dx * dx + dy * dy + dz * dz, agreement = mx * nx + my * ny + mz * nz;
      const Lanes misfit = away + 2 * square * (1 - agreement);
      IntLanes is_better = misfit < best;
      if (must_fit) is_better &= (away <= square) & (agreement >= least);
      best = is_better ? misfit : best;
      at = is_better ? IntLanes{} + static_cast<int32_t>(i) : at;
    }
    size_t lane = 0;
    for (size_t k = 1; k < 4; ++k) {
      if (best[k] < best[lane] || (best[k] == best[lane] && at[k] < at[lane])) lane = k;
    }
    return at[lane] == kNone ? kMostClusters : 4 * static_cast<size_t>(at[lane]) + lane;
  }

 private:
  static constexpr int32_t kNone = kMostClusters;
  static constexpr float kInfinite = std::numeric_limits<float>::infinity();
  static constexpr Lanes kFar = {kInfinite, kInfinite, kInfinite, kInfinite};
  using Block = std::array<Lanes, 6>;  // points and normals

  static std::array<float, 6> in_floats(const PointPush& push) {
    const Vec3 &p = push.point_O, &n = push.normal_O;
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z),
            static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  }
  static constexpr std::array<Block, kMostClusters / 4> nobody() {
    std::array<Block, kMostClusters / 4> blocks{};
    for (Block& block : blocks) block[0] = kFar;
    return blocks;
  }

  std::array<Block, kMostClusters / 4> blocks_ = nobody();
  size_t n_ = 0;
};

/// The cluster of a neighbour that was clustered shortly before; `none` if there is none.
size_t cluster_next_to(const PointPush& push, const ClusterOptions& options, const Recent& recent,
                       size_t none) {
  const double near = kNextTo * options.radius;
  for (size_t i = 1; i <= std::min(recent.n, recent.places.size()); ++i) {
    const Recent::Place& place = recent.places[(recent.n - i) % recent.places.size()];
    if (norm_squared(push.point_O - place.point_O) <= near * near &&
        dot(push.normal_O, place.normal_O) >= kSameNormal) {
      return place.cluster;
    }
  }
  return none;
}

void gather(const PointPush& push, Gathering& gathering, PushCluster& cluster) {
  const double weight = weight_of(push);
  gathering.weighted_point_O += weight * push.point_O;
  gathering.weighted_normal_O += weight * push.normal_O;
  gathering.weight += weight;
  cluster.stiffness += push.stiffness;
  ++cluster.count;
  // the nearest approaching point
  if (push.depth > 0) return;
  cluster.depth = cluster.count == 1 ? push.depth : std::max(cluster.depth, push.depth);
}

}  // namespace

LinearPush sum_pushes(std::span<const PointPush> pushes, const Vec3& about_O) {
  LinearPush sum;
  std::array<std::array<Pair, 3>, 6> less{};
  for (const PointPush& push : pushes) {
    if (!(push.depth > 0)) continue;
    const Wrench unit{push.normal_O, cross(push.point_O - about_O, push.normal_O)};
    sum.F0_O = sum.F0_O + (push.stiffness * push.depth) * unit;
    const std::array<double, 6> w = components(unit.f, unit.t);
#pragma GCC unroll 6
    for (size_t i = 0; i < 6; ++i) {
      const double row = push.stiffness * w[i];
#pragma GCC unroll 3
      for (size_t j = 0; j < 3; ++j) less[i][j] += Pair{row * w[2 * j], row * w[2 * j + 1]};
    }
  }
  for (size_t i = 0; i < 6; ++i) {
    // symmetrise: use one of the two rounded products
    for (size_t j = 0; j < 6; ++j) {
      const size_t row = std::min(i, j), column = std::max(i, j);
      sum.K(i, j) = -less[row][column / 2][column % 2];
    }
  }
  return sum;
}

size_t cluster_pushes(std::span<const PointPush> pushes, const ClusterOptions& options,
                      std::span<PushCluster> clusters) {
  HAPTIC_ASSERT(options.radius > 0);
  std::array<Gathering, kMostClusters> gatherings;
  const size_t room = std::min(clusters.size(), gatherings.size());
  size_t n = 0, n_pushing = 0;
  // pushing points first: they have priority over approaching ones
  for (const bool approaches : {false, true}) {
    const size_t first = n;
    Leaders leaders;
    Recent recent;
    for (const PointPush& push : pushes) {
      if ((push.depth <= 0) != approaches) continue;
      size_t i = cluster_next_to(push, options, recent, room);
      if (i == room) {
        const size_t leader = leaders.fitting(push, options, n < room);
        if (leader == kMostClusters && n == room) continue;
        i = leader == kMostClusters ? n : first + leader;
        recent.add(push, i);
      }
      if (i == n) {
        HAPTIC_ASSERT(n < room);
        leaders.add(push);
        gatherings[n] = {};
        clusters[n++] = {};
      }
      gather(push, gatherings[i], clusters[i]);
    }
    if (!approaches) n_pushing = n;
  }
  for (size_t i = 0; i < n; ++i) {
    const Gathering& g = gatherings[i];
    HAPTIC_ASSERT(g.weight > 0);
    clusters[i].point_O = g.weighted_point_O / g.weight;
    clusters[i].normal_O = normalized(g.weighted_normal_O);
    if (i < n_pushing) {
      clusters[i].depth = std::max(norm(g.weighted_normal_O) / clusters[i].stiffness - kFloor, 0.0);
    }
  }
  return n;
}

}  // namespace haptic

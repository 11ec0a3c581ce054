// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/cluster_pushes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "contact/query/simd/lanes.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kFloor = 1e-9;      // [m]; added to depths: a point that just touches has a weight
constexpr double kTogether = 0.5;    // share of the radius within which two clusters are one
constexpr int kMostPasses = 10;      // over the cells; each may double the number of clusters
constexpr size_t kMostCells = 512;   // what is clustered, whatever the number of points
constexpr double kCellShare = 0.25;  // edge of a cell, of the radius
constexpr double kNormalCells = 1.49;  // round(1.49 n): 26 cells, each within 30° of its middle
constexpr float kAlike = 1e-4f;        // relative; distances that rounding can exchange
constexpr double kSamePlace = 1e-9;    // coordinates of points [m], or of normals, count as equal
constexpr double kLeastBulge = 1e-6;   // less is rounding [1/m]
constexpr float kInfinite = std::numeric_limits<float>::infinity();

using Centre = ClusterMemory::Centre;

/// Weighted sums over points.
struct Gathering {
  Vec3 points_O, normals_O;
  double weight = 0, squares = 0, along = 0;  // Σ w, Σ w p², Σ w n·p
  PushCluster sum{{{}, {}, 0, 0, 0}, 0};      // stiffness, count and depth

  Centre mean() const { return {points_O / weight, normalized(normals_O)}; }

  void add(const Gathering& other) {
    points_O += other.points_O;
    normals_O += other.normals_O;
    weight += other.weight;
    squares += other.squares;
    along += other.along;
    // of those that approach: the nearest
    sum.depth = sum.count == 0 ? other.sum.depth : std::max(sum.depth, other.sum.depth);
    sum.stiffness += other.sum.stiffness;
    sum.count += other.sum.count;
  }
};

/// The points of a cluster, and the one that is farthest from its centre.
struct Members : Gathering {
  float farthest = 0;  // D²/radius²
  Centre seed;
};

/// The centres of one kind of clusters, four per block: comparing with them takes most of the time.
/// Normals are scaled by λ and everything by the radius, so that the distance is Euclidean.
class Centres {
 public:
  explicit Centres(const ClusterOptions& options)
      : place_(1 / options.radius), turn_(1 / std::sqrt(2 - 2 * options.least_agreement)) {}

  void add(const Centre& centre) {
    HAPTIC_ASSERT(n_ < kMostClusters);
    const Place own = place_of(centre);
    for (size_t k = 0; k < own.size(); ++k) blocks_[n_ / 4][k][n_ % 4] = own[k];
    ++n_;
  }

  struct Nearest {
    size_t centre = 0;
    float squared = kInfinite;  // D²/radius²
  };

  /// The nearest centre. Most points lie next to the one before, and within half the difference of
  /// its distances from the two nearest centres the nearest is the same.
  Nearest nearest(const Centre& point) {
    const Place own = place_of(point);
    const float way = std::sqrt(squared_between(own, last_));
    if (2 * way < last_lead_) return {last_centre_, squared_between(own, place(last_centre_))};
    Lanes best = kFar, second = kFar;
    IntLanes at{};
    for (size_t i = 0; 4 * i < n_; ++i) {
      Lanes squared{};
      for (size_t k = 0; k < own.size(); ++k) {
        const Lanes along = blocks_[i][k] - own[k];
        squared += along * along;
      }
      const IntLanes is_nearer = squared < best;
      const Lanes worse = is_nearer ? best : squared;
      second = worse < second ? worse : second;
      best = is_nearer ? squared : best;
      at = is_nearer ? IntLanes{} + static_cast<int32_t>(i) : at;
    }
    size_t lane = 0;
    for (size_t k = 1; k < 4; ++k) {
      if (best[k] < best[lane] || (best[k] == best[lane] && at[k] < at[lane])) lane = k;
    }
    float next = kInfinite;
    for (size_t k = 0; k < 4; ++k) next = std::min(next, k == lane ? second[k] : best[k]);
    last_ = own;
    last_centre_ = 4 * static_cast<size_t>(at[lane]) + lane;
    last_lead_ = std::sqrt(next) - std::sqrt(best[lane]);
    return {last_centre_, best[lane]};
  }

 private:
  static constexpr Lanes kFar = {kInfinite, kInfinite, kInfinite, kInfinite};
  using Place = std::array<float, 6>;
  using Block = std::array<Lanes, 6>;

  Place place_of(const Centre& c) const {
    const Vec3 p = place_ * c.point_O, n = turn_ * c.normal_O;
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z),
            static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  }
  Place place(size_t i) const {
    Place own{};
    for (size_t k = 0; k < own.size(); ++k) own[k] = blocks_[i / 4][k][i % 4];
    return own;
  }
  static float squared_between(const Place& a, const Place& b) {
    float sum = 0;
    for (size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum;
  }
  static constexpr std::array<Block, kMostClusters / 4> nobody() {
    std::array<Block, kMostClusters / 4> blocks{};
    for (Block& block : blocks) block[0] = kFar;
    return blocks;
  }

  double place_, turn_;
  std::array<Block, kMostClusters / 4> blocks_ = nobody();
  size_t n_ = 0;
  Place last_{};
  size_t last_centre_ = 0;
  float last_lead_ = 0;
};

/// D²/radius² of two centres.
double squared_between(const Centre& a, const Centre& b, const ClusterOptions& options) {
  const double turn = norm_squared(a.normal_O - b.normal_O) / (2 - 2 * options.least_agreement);
  return norm_squared(a.point_O - b.point_O) / (options.radius * options.radius) + turn;
}

/// An order of places that depends neither on their numbering nor on rounding.
bool is_before(const Centre& a, const Centre& b) {
  const std::array<double, 6> p = components(a.point_O, a.normal_O);
  const std::array<double, 6> q = components(b.point_O, b.normal_O);
  for (size_t i = 0; i < p.size(); ++i) {
    if (std::fabs(p[i] - q[i]) > kSamePlace) return p[i] < q[i];
  }
  return false;
}

/// Whether a seed goes before another: the farther one, of those alike the first in order.
bool goes_before(float squared, const Centre& seed, float other_squared, const Centre& other) {
  if (squared > (1 + kAlike) * other_squared) return true;
  return other_squared <= (1 + kAlike) * squared && is_before(seed, other);
}

/// Where there is no room for a cluster of its own; kMostClusters: no normal agrees.
size_t nearest_that_agrees(const ClusterMemory::Kind& kind, const Centre& point,
                           const ClusterOptions& options) {
  size_t nearest = kMostClusters;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < kind.size; ++i) {
    const Centre& c = kind.centres[i];
    if (dot(c.normal_O, point.normal_O) < options.least_agreement) continue;
    const double squared = squared_between(c, point, options);
    if (squared < least) least = squared, nearest = i;
  }
  return nearest;
}

Gathering alone(const PointPush& push, double weight) {
  Gathering one;
  one.points_O = weight * push.point_O;
  one.normals_O = weight * push.normal_O;
  one.weight = weight;
  one.squares = weight * norm_squared(push.point_O);
  one.along = weight * dot(push.normal_O, push.point_O);
  one.sum.stiffness = push.stiffness;
  one.sum.count = 1;
  one.sum.depth = push.depth;
  return one;
}

/// The pushes of one kind, and what their depths are counted from.
struct Kind {
  std::span<const PointPush> pushes;
  bool approaches = false;
  double tolerance = 0;
};

/// The points of one kind, merged where they are close and their normals alike; K-means sees these.
class Cells {
 public:
  /// Cells of a quarter of the radius in space, and 26 of the normals; each time that they are too
  /// many it begins anew with cells twice as wide.
  Cells(const Kind& kind, double radius) {
    for (double edge = kCellShare * radius; !fill(kind, edge); edge *= 2) {
    }
  }
  std::span<const Gathering> all() const { return {cells_.data(), n_}; }

 private:
  static constexpr size_t kSlots = 2 * kMostCells;  // a power of two
  using Key = std::array<int64_t, 6>;

  bool fill(const Kind& kind, double edge) {
    n_ = 0;
    slots_.fill(0);
    for (const PointPush& push : kind.pushes) {
      if ((push.depth <= 0) != kind.approaches) continue;
      const double weight = push.stiffness * (std::max(push.depth + kind.tolerance, 0.0) + kFloor);
      if (!add(alone(push, weight), key_of(push, edge))) return false;
    }
    return true;
  }
  static Key key_of(const PointPush& push, double edge) {
    const Vec3 p = push.point_O / edge, n = kNormalCells * push.normal_O;
    return {std::llround(p.x), std::llround(p.y), std::llround(p.z),
            std::llround(n.x), std::llround(n.y), std::llround(n.z)};
  }
  bool add(const Gathering& point, const Key& key) {
    uint64_t hash = 0;
    for (const int64_t part : key) {
      hash = (hash ^ static_cast<uint64_t>(part)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
    size_t slot = hash % kSlots;
    for (; slots_[slot] != 0; slot = (slot + 1) % kSlots) {
      const size_t cell = slots_[slot] - 1u;
      if (keys_[cell] != key) continue;
      cells_[cell].add(point);
      return true;
    }
    if (n_ == kMostCells) return false;
    keys_[n_] = key;
    cells_[n_] = point;
    slots_[slot] = static_cast<uint16_t>(++n_);
    return true;
  }

  std::array<uint16_t, kSlots> slots_;  // 1 + number of a cell; 0: none
  std::array<Key, kMostCells> keys_;
  union {
    std::array<Gathering, kMostCells> cells_;  // not initialised: most questions need few
  };
  size_t n_ = 0;
};

using Gatherings = std::array<Members, kMostClusters>;

/// Assigns each cell to its nearest centre. While there is room, those farther than the radius from
/// all centres wait, and the farthest of each are seeds; the first of all is the heaviest. Returns
/// whether there is a seed.
bool assign(const Cells& cells, const ClusterOptions& options, const ClusterMemory::Kind& centres,
            bool has_room, Gatherings& gatherings) {
  Centres near(options);
  for (size_t i = 0; i < centres.size; ++i) near.add(centres.centres[i]);
  for (size_t i = 0; i < std::max<size_t>(centres.size, 1); ++i) gatherings[i] = {};
  bool has_seed = false;
  for (const Gathering& cell : cells.all()) {
    const Centre point = cell.mean();
    Centres::Nearest at{0, static_cast<float>(2 + cell.weight)};
    if (centres.size > 0) at = near.nearest(point);
    const bool is_far = at.squared > 1;
    if (is_far && has_room) {
      Members& g = gatherings[at.centre];
      if (goes_before(at.squared, point, g.farthest, g.seed)) {
        g.farthest = at.squared, g.seed = point;
      }
      has_seed = true;
      continue;
    }
    if (is_far) at.centre = nearest_that_agrees(centres, point, options);
    if (at.centre < centres.size) gatherings[at.centre].add(cell);
  }
  return has_seed;
}

/// The clusters' means, without those that have no points, then merges those that are together.
void move_centres(const ClusterOptions& options, const Gatherings& gatherings,
                  ClusterMemory::Kind& centres) {
  const size_t n = centres.size;
  centres.size = 0;
  for (size_t i = 0; i < n; ++i) {
    const Members& g = gatherings[i];
    if (g.sum.count == 0) continue;
    const Centre mean = g.mean();
    const bool is_known = std::any_of(
        centres.centres.begin(), centres.centres.begin() + centres.size,
        [&](const Centre& c) { return squared_between(c, mean, options) < kTogether * kTogether; });
    if (!is_known) centres.centres[centres.size++] = mean;
  }
}

/// The farthest points of the old clusters become centres, the farthest of all first, unless a new
/// one is within the radius.
void add_seeds(const ClusterOptions& options, size_t n_gathered, size_t room,
               const Gatherings& gatherings, ClusterMemory::Kind& centres) {
  std::array<bool, kMostClusters> is_used{};
  const size_t n_old = centres.size;
  while (centres.size < room) {
    const Members* farthest = nullptr;
    for (size_t i = 0; i < n_gathered; ++i) {
      const Members& g = gatherings[i];
      if (is_used[i] || !(g.farthest > 1)) continue;
      if (farthest == nullptr ||
          goes_before(g.farthest, g.seed, farthest->farthest, farthest->seed))
        farthest = &g;
    }
    if (farthest == nullptr) return;
    is_used[static_cast<size_t>(farthest - gatherings.data())] = true;
    const auto begin = centres.centres.begin();
    if (std::none_of(begin + n_old, begin + centres.size, [&](const Centre& c) {
          return squared_between(c, farthest->seed, options) <= 1;
        })) {
      centres.centres[centres.size++] = farthest->seed;
    }
  }
}

PushCluster cluster_of(const Gathering& g, bool approaches) {
  HAPTIC_ASSERT(g.weight > 0);
  PushCluster cluster = g.sum;
  const Centre mean = g.mean();
  cluster.point_O = mean.point_O;
  cluster.normal_O = mean.normal_O;
  if (!approaches) {
    // weights are forces, but for the floor
    cluster.depth = std::max(norm(g.normals_O) / cluster.stiffness - kFloor, 0.0);
  }
  const double spread = g.squares / g.weight - norm_squared(cluster.point_O);
  const double closing = dot(g.normals_O, g.points_O) / (g.weight * g.weight) - g.along / g.weight;
  const double bulge = cluster.count > 1 && spread > 0 ? closing / spread : 0;
  cluster.bulge = std::fabs(bulge) > kLeastBulge ? bulge : 0;
  return cluster;
}

size_t cluster_kind(const Kind& kind, const ClusterOptions& options, ClusterMemory::Kind& centres,
                    std::span<PushCluster> clusters) {
  const size_t room = std::min(clusters.size(), kMostClusters);
  centres.size = std::min(centres.size, room);
  if (room == 0) return 0;
  const Cells cells(kind, options.radius);
  Gatherings gatherings;
  bool is_known = false;
  for (int pass = 0;; ++pass) {
    const bool is_last = pass == kMostPasses;
    const bool has_seed =
        assign(cells, options, centres, centres.size < room && !is_last, gatherings);
    // once without seeds the centres move, then the points are assigned for good
    if (is_last || (is_known && !has_seed)) break;
    is_known = !has_seed;
    const size_t n_gathered = std::max<size_t>(centres.size, 1);
    move_centres(options, gatherings, centres);
    add_seeds(options, n_gathered, room, gatherings, centres);
  }
  size_t n = 0;
  for (size_t i = 0; i < centres.size; ++i) {
    if (gatherings[i].sum.count > 0) clusters[n++] = cluster_of(gatherings[i], kind.approaches);
  }
  move_centres(options, gatherings, centres);
  return n;
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

void share_stiffness(std::span<PointPush> pushes, double stiffness, double sharing) {
  HAPTIC_ASSERT(stiffness > 0 && sharing > 0);
  double sum = 0, squares = 0;
  for (const PointPush& push : pushes) {
    // those that just touch push equally hard
    const double depth = std::max(push.depth, 0.0) + kFloor;
    sum += depth, squares += depth * depth;
  }
  const double alike = squares > 0 ? sum * sum / squares : 0;
  const double shared = alike > sharing ? stiffness * sharing / alike : stiffness;
  for (PointPush& push : pushes) push.stiffness = shared;
}

size_t cluster_pushes(std::span<const PointPush> pushes, const ClusterOptions& options,
                      ClusterMemory& memory, std::span<PushCluster> clusters) {
  HAPTIC_ASSERT(options.radius > 0 && options.least_agreement < 1 && options.tolerance >= 0);
  // pushing points first: they have priority over approaching ones
  const size_t n = cluster_kind({pushes, false, 0}, options, memory.pushing, clusters);
  return n + cluster_kind({pushes, true, options.tolerance}, options, memory.approaching,
                          clusters.subspan(n));
}

}  // namespace haptic

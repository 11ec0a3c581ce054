// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/point/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "contact/query/point/patch_lanes.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kReach = 10;            // in triangle sizes: a longer move is a jump
constexpr double kAhead = 3;             // moves like the last one for which a front is made
constexpr double kRest = 0.3;            // least distance a front is made for, in triangle sizes
constexpr double kRoundings = 1 - 1e-9;  // covers the rounding in the test of a front
constexpr size_t kBatch = 4;             // leaves processed together

struct Waiting {
  float distance_squared;  // lower bound
  uint32_t child;
};

/// Stack of patches; among the children of a node the nearest is on top.
struct Waitlist {
  std::array<Waiting, (kMaxPatchDepth + kFrontNodes) * kPatchLanes> patches;
  size_t size = 0;

  HAPTIC_INLINE void add(LaneSet lanes, Float8 distance_squared, const PatchNode& node,
                         const PatchTree& tree) {
    HAPTIC_ASSERT(size + kPatchLanes <= patches.size());
    PatchNode::Lanes distances;
    std::memcpy(distances.data(), &distance_squared, sizeof distances);
    for (const size_t first = size; lanes.any(); lanes.pop()) {
      const size_t lane = lanes.first();
      const Waiting next{distances[lane], node.child[lane]};
      if ((next.child & kPatchLeaf) != 0) {
        __builtin_prefetch(&tree.leaves[next.child & ~kPatchLeaf]);
      }
      size_t at = size++;
      for (; at > first && patches[at - 1].distance_squared < next.distance_squared; --at) {
        patches[at] = patches[at - 1];
      }
      patches[at] = next;
    }
  }
};

struct Candidate {
  float at_least;  // of its distance [m]
  uint32_t triangle;
};

/// Search for the nearest triangle; among equally near ones, the one with the lowest index.
class NearestSearch {
 public:
  HAPTIC_INLINE NearestSearch(const MeshShape& shape, const PatchProbe& probe, double max_distance,
                              float limit)
      : shape_(shape), probe_(probe) {
    best_ = max_distance * max_distance;
    lower_limit(limit);
  }

  HAPTIC_INLINE void search_all() {
    open(0);
    drain();
  }

  HAPTIC_INLINE void search_below(std::span<const uint32_t> nodes) {
    for (const uint32_t node : nodes) open(node);
    drain();
  }

  /// Decides among the candidates in double; false if there is nothing.
  HAPTIC_INLINE bool finish_search() {
    settle();
    return triangle_ != kNoFace;
  }
  ClosestPoint result() const {
    return closest_point_on_triangle(shape_.mesh, triangle_, on_, probe_.p_O);
  }

 private:
  HAPTIC_INLINE void open(uint32_t index) {
    const PatchNode& node = shape_.patches.nodes[index];
    Float8 distance_squared;
    const LaneSet lanes =
        patches_near(node, probe_, limit_squared_, Facing::kEitherSide, distance_squared);
    waiting_.add(lanes, distance_squared, node, shape_.patches);
  }

  /// Processes leaves in batches, before it opens more nodes: they tighten the limit.
  HAPTIC_INLINE void drain() {
    for (;;) {
      std::array<const PatchLeaf*, kBatch> batch;
      size_t n = 0;
      while (waiting_.size > 0 && n < kBatch) {
        const Waiting next = waiting_.patches[waiting_.size - 1];
        const bool is_near = !(next.distance_squared > limit_squared_) && next.child != kNoPatch;
        const bool is_leaf = (next.child & kPatchLeaf) != 0;
        if (is_near && !is_leaf && n > 0) break;
        --waiting_.size;
        if (!is_near) continue;
        if (is_leaf) {
          batch[n++] = &shape_.patches.leaves[next.child & ~kPatchLeaf];
        } else {
          open(next.child);
        }
      }
      if (n == 0) return;
      visit({batch.data(), n});
    }
  }

  HAPTIC_INLINE void lower_limit(float limit) {
    limit_ = limit;
    limit_squared_ = limit_squared(limit);
  }

  HAPTIC_INLINE void visit(std::span<const PatchLeaf* const> batch) {
    if (n_candidates_ + kBatch * kPatchLanes > candidates_.size()) settle();
    HAPTIC_ASSERT(n_candidates_ + batch.size() * kPatchLanes <= candidates_.size());
    std::array<Float8, kBatch> at_least;
    Float8 nearest = lanes8::splat(limit_);
    for (size_t i = 0; i < batch.size(); ++i) {
      Float8 at_most;
      bound_triangles(*batch[i], probe_, at_least[i], at_most);
      nearest = lanes8::smaller(at_most, nearest);
    }
    lower_limit(lanes8::least(nearest));
    for (size_t i = 0; i < batch.size(); ++i) {
      const PatchLeaf& leaf = *batch[i];
      LaneSet lanes = lanes_near(leaf, at_least[i], limit_);
      for (; lanes.any(); lanes.pop()) {
        const size_t lane = lanes.first();
        const uint32_t triangle = leaf.triangle[lane];
        __builtin_prefetch(&shape_.mesh.triangles[triangle]);
        candidates_[n_candidates_++] = {at_least[i][lane], triangle};
      }
    }
  }

  /// Computes the distances of the candidates in double.
  HAPTIC_INLINE void settle() {
    size_t n = 0;
    for (size_t i = 0; i < n_candidates_; ++i) {
      const Candidate& c = candidates_[i];
      if (c.at_least > limit_) continue;
      for (const uint32_t v : shape_.mesh.triangles[c.triangle]) {
        __builtin_prefetch(&shape_.mesh.vertices[v]);
      }
      candidates_[n++] = c;
    }
    n_candidates_ = 0;
    for (size_t i = 0; i < n; ++i) {
      const uint32_t triangle = candidates_[i].triangle;
      const OnTriangle on = closest_on_triangle(shape_.mesh, triangle, probe_.p_O);
      const double d = norm_squared(probe_.p_O - on.point);
      if (d > best_ || (d == best_ && triangle > triangle_)) continue;
      best_ = d;
      triangle_ = triangle;
      on_ = on;
    }
    if (n > 0) lower_limit(std::min(limit_, round_up_distance(std::sqrt(best_))));
  }

  const MeshShape& shape_;
  const PatchProbe& probe_;
  double best_ = 0;  // squared [m²]
  float limit_ = 0, limit_squared_ = 0;
  uint32_t triangle_ = kNoFace;
  OnTriangle on_{};
  Waitlist waiting_;
  std::array<Candidate, 64> candidates_;
  size_t n_candidates_ = 0;
};

}  // namespace

/// Search that starts from the witness.
class WitnessedSearch {
 public:
  HAPTIC_INLINE WitnessedSearch(const MeshShape& shape, const Vec3& p_O, ClosestWitness& witness)
      : shape_(shape), probe_(p_O), witness_(witness) {}

  HAPTIC_INLINE ClosestPoint run(double max_distance) {
    const double moved = norm(probe_.p_O - witness_.p_O_);
    const bool is_jump = witness_.tree_ != shape_.patches.nodes.data() ||
                         !(moved < kReach * witness_.triangle_size_);
    if (is_jump) {
      witness_.clearance_ = 0;
      return remember(closest_point(shape_, probe_.p_O, max_distance));
    }
    // the point found last time gives an upper bound
    const float limit = std::min(round_up_distance(max_distance),
                                 round_up_distance(norm(probe_.p_O - witness_.point_O_)));
    if (!proves(static_cast<double>(limit))) {
      const double ahead = std::max(kAhead * moved, kRest * witness_.triangle_size_);
      collect(static_cast<double>(limit) + ahead);
    }
    NearestSearch nearest(shape_, probe_, max_distance, limit);
    nearest.search_below({witness_.nodes_.data(), witness_.n_nodes_});
    return nearest.finish_search() ? remember(nearest.result()) : ClosestPoint{};
  }

 private:
  HAPTIC_INLINE const ClosestPoint& remember(const ClosestPoint& closest) {
    if (!closest.found) return closest;
    const Triangle& tri = shape_.mesh.triangles[closest.triangle];
    const Vec3& corner = shape_.mesh.vertices[tri[0]];
    witness_.tree_ = shape_.patches.nodes.data();
    witness_.p_O_ = probe_.p_O;
    witness_.point_O_ = closest.point_O;
    witness_.triangle_size_ = std::max(norm(shape_.mesh.vertices[tri[1]] - corner),
                                       norm(shape_.mesh.vertices[tri[2]] - corner));
    return closest;
  }

  /// Whether everything within this distance lies below the front, by the triangle inequality.
  HAPTIC_INLINE bool proves(double distance) const {
    return norm(probe_.p_O - witness_.centre_O_) + distance < kRoundings * witness_.clearance_;
  }

  /// New front around the point: the deepest level at which at most kFrontNodes nodes contain
  /// everything within the radius.
  HAPTIC_INLINE void collect(double radius) {
    const float limit = limit_squared(round_up_distance(radius));
    witness_.centre_O_ = probe_.p_O;
    witness_.clearance_ = radius;
    witness_.n_nodes_ = 1;
    witness_.nodes_[0] = 0;
    std::array<uint32_t, kFrontNodes> below;
    for (size_t n = 0; collect_below(limit, below, n) && n > 0; n = 0) {
      witness_.n_nodes_ = n;
      std::copy_n(below.begin(), n, witness_.nodes_.begin());
    }
  }

  /// The next level of the front; false if it does not fit or reaches leaves.
  HAPTIC_INLINE bool collect_below(float limit, std::array<uint32_t, kFrontNodes>& below,
                                   size_t& n) const {
    for (size_t i = 0; i < witness_.n_nodes_; ++i) {
      const PatchNode& node = shape_.patches.nodes[witness_.nodes_[i]];
      Float8 ignored;
      LaneSet lanes = patches_near(node, probe_, limit, Facing::kAny, ignored);
      for (; lanes.any(); lanes.pop()) {
        const uint32_t child = node.child[lanes.first()];
        if (child == kNoPatch) continue;
        if ((child & kPatchLeaf) != 0 || n == below.size()) return false;
        below[n++] = child;
      }
    }
    return true;
  }

  const MeshShape& shape_;
  const PatchProbe probe_;
  ClosestWitness& witness_;
};

HAPTIC_WIDE ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O,
                                       double max_distance) {
  if (shape.patches.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  const PatchProbe probe(p_O);
  NearestSearch nearest(shape, probe, max_distance, round_up_distance(max_distance));
  nearest.search_all();
  return nearest.finish_search() ? nearest.result() : ClosestPoint{};
}

HAPTIC_WIDE ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance,
                                       ClosestWitness& witness) {
  if (shape.patches.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  return WitnessedSearch(shape, p_O, witness).run(max_distance);
}

bool holds(const MeshShape& outer, std::span<const Vec3> points, const Pose& X_outer_inner) {
  HAPTIC_ASSERT(is_unit(X_outer_inner.q));
  if (!outer.mesh.closed) return false;
  return std::any_of(points.begin(), points.end(), [&](const Vec3& point) {
    const double any_distance = std::numeric_limits<double>::infinity();
    return closest_point(outer, X_outer_inner * point, any_distance).inside;
  });
}

}  // namespace haptic

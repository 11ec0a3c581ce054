// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/query/patch_tests.h"

namespace haptic {
namespace {

constexpr double kReach = 16;             // leaves: a move of a few patches is a little one
constexpr float kFloatSlack = 1 + 1e-5F;  // more than the roundings of a sum of squares

struct Waiting {
  float distance_squared;  // at least
  uint32_t child;
  uint32_t node;  // which holds it
};

/// Patches still to be looked at, the nearest of a node last.
struct Waitlist {
  std::array<Waiting, kMaxPatchDepth * kPatchLanes> patches;
  size_t size = 0;

  void add(LaneSet lanes, const PatchNode::Lanes& distance_squared, const PatchNode& node,
           uint32_t index) {
    for (const size_t first = size; lanes.any(); lanes.pop()) {
      const size_t lane = lanes.first();
      const Waiting next{distance_squared[lane], node.child[lane], index};
      size_t at = size++;
      for (; at > first && patches[at - 1].distance_squared < next.distance_squared; --at) {
        patches[at] = patches[at - 1];
      }
      patches[at] = next;
    }
  }
};

/// A triangle that may be the nearest.
struct Candidate {
  float at_least;  // its distance
  uint32_t triangle;
  uint32_t node;  // above its leaf
  float size;     // of its leaf
};

/// The search for the nearest triangle; among equally near ones for the lowest index.
class NearestSearch {
 public:
  NearestSearch(const MeshShape& shape, const Vec3& p_O, double max_distance)
      : shape_(shape), p_O_(p_O), probe_(p_O) {
    best_ = max_distance * max_distance;
    lower_limit(round_up_distance(max_distance));
  }

  /// Everything below a node.
  void search(uint32_t node) {
    open(node, kPatchLanes);
    drain();
  }

  /// Everything below the parent of a node but what was searched: the node itself. Returns the
  /// parent.
  uint32_t search_around(uint32_t node) {
    const uint32_t parent = shape_.patches.nodes[node].parent;
    open(parent / kPatchLanes, parent % kPatchLanes);
    drain();
    return parent / kPatchLanes;
  }

  /// Settles it in double among the candidates; false where there is nothing.
  bool finish_search() {
    settle();
    return triangle_ != kNoFace;
  }
  /// Of where it was found: the node above the leaf, and the longest side of the leaf.
  uint32_t node() const { return best_leaf_.node; }
  double leaf_size() const { return static_cast<double>(best_leaf_.size); }
  ClosestPoint result() const {
    return closest_point_on_triangle(shape_.mesh, triangle_, on_, p_O_);
  }

 private:
  void lower_limit(float limit) {
    limit_ = limit;
    limit_squared_ = limit * limit * kFloatSlack;
  }

  void open(uint32_t index, size_t but_lane) {
    const PatchNode& node = shape_.patches.nodes[index];
    PatchNode::Lanes distance_squared;
    LaneSet lanes = patches_near(node, probe_, limit_, Facing::kEitherSide, distance_squared);
    if (but_lane < kPatchLanes) lanes.remove(but_lane);
    waiting_.add(lanes, distance_squared, node, index);
  }

  void drain() {
    while (waiting_.size > 0) {
      const Waiting next = waiting_.patches[--waiting_.size];
      if (next.distance_squared > limit_squared_ || next.child == kNoPatch) continue;
      if ((next.child & kPatchLeaf) == 0) {
        open(next.child, kPatchLanes);
      } else {
        visit(shape_.patches.leaves[next.child & ~kPatchLeaf], next.node);
      }
    }
  }

  void visit(const PatchLeaf& leaf, uint32_t node) {
    if (n_candidates_ + kPatchLanes > candidates_.size()) settle();
    float limit = limit_;
    PatchNode::Lanes steps_squared;
    LaneSet lanes = triangles_near(leaf, probe_, true, limit, steps_squared);
    if (limit < limit_) lower_limit(limit);
    for (; lanes.any(); lanes.pop()) {
      const size_t lane = lanes.first();
      const uint32_t triangle = leaf.triangle[lane];
      __builtin_prefetch(&shape_.mesh.triangles[triangle]);
      candidates_[n_candidates_++] = {distance_at_least(leaf, steps_squared[lane]), triangle, node,
                                      leaf.step * static_cast<float>(kPatchSteps)};
    }
  }

  /// Looks the candidates up in the mesh.
  void settle() {
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
      const OnTriangle on = closest_on_triangle(shape_.mesh, triangle, p_O_);
      const double d = norm_squared(p_O_ - on.point);
      if (d > best_ || (d == best_ && triangle > triangle_)) continue;
      best_ = d;
      triangle_ = triangle;
      on_ = on;
      best_leaf_ = candidates_[i];
    }
    if (n > 0) lower_limit(std::min(limit_, round_up_distance(std::sqrt(best_))));
  }

  const MeshShape& shape_;
  Vec3 p_O_;
  PatchProbe probe_;
  double best_ = 0;  // squared
  float limit_ = 0, limit_squared_ = 0;
  uint32_t triangle_ = kNoFace;
  Candidate best_leaf_{};
  OnTriangle on_{};
  Waitlist waiting_;
  std::array<Candidate, 64> candidates_;
  size_t n_candidates_ = 0;
};

/// Whether the box of one lane holds q.
bool holds(const PatchNode& node, size_t lane, const Vec3& q) {
  for (size_t k = 0; k < 3; ++k) {
    const double x = q[static_cast<int>(k)];
    if (!(x >= static_cast<double>(node.lower[k][lane]))) return false;
    if (!(x <= static_cast<double>(node.upper[k][lane]))) return false;
  }
  return true;
}

/// Where to begin: the smallest node above the witness that holds where the closest point would be
/// if it moved as p did; the root after a jump.
uint32_t first_node(const PatchTree& patches, const Vec3& p_O, const ClosestWitness& witness) {
  const Vec3 moved_O = p_O - witness.p_O;
  if (!(norm_squared(moved_O) < witness.reach * witness.reach)) return 0;
  if (witness.node >= patches.nodes.size()) return 0;
  const Vec3 guess_O = witness.point_O + moved_O;
  uint32_t node = witness.node;
  while (node != 0) {
    const uint32_t parent = patches.nodes[node].parent;
    if (holds(patches.nodes[parent / kPatchLanes], parent % kPatchLanes, guess_O)) break;
    node = static_cast<uint32_t>(parent / kPatchLanes);
  }
  return node;
}

}  // namespace

ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance) {
  if (shape.patches.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  NearestSearch nearest(shape, p_O, max_distance);
  nearest.search(0);
  return nearest.finish_search() ? nearest.result() : ClosestPoint{};
}

ClosestPoint closest_point(const MeshShape& shape, const Vec3& p_O, double max_distance,
                           ClosestWitness& witness) {
  if (shape.patches.nodes.empty() || !(max_distance >= 0) || !is_finite(p_O)) return {};
  NearestSearch nearest(shape, p_O, max_distance);
  uint32_t node = first_node(shape.patches, p_O, witness);
  nearest.search(node);
  // a bound is known: what lies around it is soon done with
  while (node != 0) node = nearest.search_around(node);
  if (!nearest.finish_search()) return {};
  const ClosestPoint closest = nearest.result();
  witness = {p_O, closest.point_O, kReach * nearest.leaf_size(), nearest.node()};
  return closest;
}

}  // namespace haptic

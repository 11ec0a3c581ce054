// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/query/box/box_distance.h"
#include "contact/query/proximity/leaf_bounds.h"
#include "contact/query/proximity/near_pairs.h"
#include "contact/query/proximity/sliding_planes.h"

namespace haptic {

/// near_pairs with temporal coherence: keeps the front of the bounding-volume-tree traversal, the
/// pairs of nodes too far apart to be opened, each with a separating plane. Leaf pairs that no
/// single plane separates keep one per pair of triangles. All planes move along with B at once;
/// sliding along a plane does not consume its gap. A pair is tested again only when its gap is
/// consumed; two far siblings are merged into their parent. Fronts as in Klosowski et al. 1998 and
/// Ehmann & Lin 2001, kept separating planes as in Chung & Wang 1996. Copies the corners of both
/// meshes at construction; front and pairs allocate until they have held the largest.
class NearFront {
 public:
  /// The arrays that both shapes view must outlive it.
  NearFront(const MeshShape& shape_A, const MeshShape& shape_B);

  /// The pairs that near_pairs() finds, in unspecified order, valid until the next call.
  std::span<const NearPair> update(const Pose& X_AB, double band);

  /// The pairs at the end of a motion from the pose of the previous update (up to rounding). Also
  /// finds the triangles that may have met on the way: only the suspects, as long as no point of B
  /// deviates from the straight line between its end points by half the band. The cost grows with
  /// the length of the motion. Says nothing about the motion to a first update: is_first().
  std::span<const NearPair> follow(const RigidMotion& motion, const Pose& X_AB, double band);
  std::span<const TrianglePair> suspects() const { return suspects_; }
  bool is_first() const { return is_fresh_; }

  /// Discards the front; the next update starts from the roots.
  void forget() { is_fresh_ = true; }

  /// Cost of the last update: node pairs, box tests, triangle pairs.
  struct Work {
    size_t visited = 0, boxes = 0, triangles = 0;
  };
  const Work& work() const { return work_; }
  size_t size() const { return pairs_.size(); }

 private:
  static constexpr uint32_t kNone = ~0u;

  enum class State : uint8_t { kUnused, kFar, kOpen, kLeaves };
  struct Pair {
    NodePair nodes;
    uint32_t parent = kNone;
    uint32_t below = kNone;  // open: its first child; leaves: index of their bounds
    State state = State::kUnused;
  };
  /// Lower bound of the distance of two boxes, and the plane that separates them.
  struct Apart {
    double at_least = 0;  // [m]
    SlidingPlane plane;
  };

  std::span<const NearPair> nearer_than(double band);
  void begin();
  void retire();
  void move_leaves();
  void visit_expired();
  void visit(uint32_t index, const Vec3& normal_A);
  void prefetch_corners(const NodePair& nodes) const;
  void open(uint32_t index);
  void begin_leaves(uint32_t index);
  void ask(const LeafBounds& bounds);
  void measure_waiting();
  void leave_leaves(uint32_t index);
  void end_leaves(uint32_t index);
  void close_some();
  void raise(uint32_t index, SlidingPlane plane);
  std::optional<SlidingPlane> close(uint32_t index, double gap);
  void wait_far(uint32_t index, const SlidingPlane& plane);
  uint32_t new_halves();
  Apart apart(const NodePair& nodes);
  double gap_along(const NodePair& nodes, const Vec3& normal_A, const BoxDistance& boxes,
                   const Pose& X_AB) const;
  bool is_far(const NodePair& nodes, const Apart& apart) const;
  bool was_apart(size_t i, size_t corners_A, size_t corners_B) const;
  bool is_leaves(const NodePair& nodes) const;
  const ObbNode& node_a(const NodePair& nodes) const { return shape_A_.tree.nodes[nodes.a]; }
  const ObbNode& node_b(const NodePair& nodes) const { return shape_B_.tree.nodes[nodes.b]; }

  MeshShape shape_A_, shape_B_;
  std::vector<Corners> corners_A_, corners_B_;  // in tree order
  double reach_B_ = 0;                      // largest distance of a vertex of B from its origin [m]
  std::vector<Pair> pairs_;                 // siblings adjacent, the root first
  SlidingPlanes planes_;                    // of the far pairs
  std::vector<LeafBounds> bounds_;          // of the leaf pairs
  std::vector<uint32_t> unused_, retired_;  // first of two siblings: free; freed in this update
  std::vector<SlidingPlanes::UsedUp> expired_;
  std::vector<uint32_t> looked_at_;                      // leaf pairs
  size_t n_leaves_asked_ = 0, n_planes_asked_ = 0;       // cursors of the amortised coarsening
  std::array<uint32_t, DistanceBatch::kRoom> leaves_{};  // leaf pairs whose triangles are in batch_
  size_t n_leaves_ = 0;
  std::vector<NearPair> near_;
  std::vector<TrianglePair> suspects_;
  DistanceBatch batch_;
  struct Waiting {
    uint32_t pair, triangle;
  };
  std::array<Waiting, DistanceBatch::kRoom> waiting_{};
  Work work_;
  Pose X_AB_, X_AB_before_;
  PoseChange change_;
  BoxDistance boxes_{Pose{}}, boxes_before_{Pose{}};
  double band_ = 0;
  bool is_fresh_ = true;
  const ObbSweep* sweep_ = nullptr;  // of the motion in follow(), else null
};

}  // namespace haptic

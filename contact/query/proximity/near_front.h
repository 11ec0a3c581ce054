// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/query/box/box_distance.h"
#include "contact/query/proximity/leaf_bounds.h"
#include "contact/query/proximity/near_pairs.h"
#include "contact/query/proximity/sliding_planes.h"

namespace haptic {

/// near_pairs from pose to pose. It remembers the front of the double descent: the pairs of nodes
/// that were too far apart to be opened, with a plane between them and how far apart they are
/// across it, and in pairs of leaves that no plane keeps apart one between each two triangles. All
/// planes go along with B at once; sliding past each other uses nothing up. A pair is looked at
/// again when its gap is used up. Siblings that are both far are replaced by their parent. Fronts
/// as in Klosowski et al. 1998 and Ehmann & Lin 2001, witnesses instead of tests on every step as
/// in Chung & Wang 1996. Room for the corners of both meshes is made at construction; that for the
/// front and its pairs grows until it has held the largest.
class NearFront {
 public:
  /// Views of both shapes must outlive it.
  NearFront(const MeshShape& shape_A, const MeshShape& shape_B);

  /// The same set as near_pairs, in an order of its own, until the next call.
  std::span<const NearPair> update(const Pose& X_AB, double band);

  /// The same at this pose, the end of a motion that begins at the pose of the update before (to
  /// roundings), and what may have met on the way: while no point of B is as far as half the band
  /// off the straight line between its ends, no two triangles did but the suspects. Costs more the
  /// longer the way is. Of a first update nothing is known: is_first().
  std::span<const NearPair> follow(const RigidMotion& motion, const Pose& X_AB, double band);
  std::span<const TrianglePair> suspects() const { return suspects_; }
  bool is_first() const { return is_fresh_; }

  /// Whether there is any: the pair of last time is asked first, then a short search from scratch,
  /// and only where that does not end either the front is brought up to date.
  bool any_near_pair(const Pose& X_AB, double band);

  /// Begins anew: nothing is remembered.
  void forget() { is_fresh_ = true; }

  /// What the last update came to.
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
    uint32_t below = kNone;  // open: the first of its halves; leaves: their bounds
    State state = State::kUnused;
  };
  /// Two boxes, and the plane between them.
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
  std::vector<Corners> corners_A_, corners_B_;  // in the order of the trees
  double reach_B_ = 0;                          // of B from its origin [m]
  std::vector<Pair> pairs_;                     // halves of a pair side by side, the root first
  SlidingPlanes planes_;                        // of pairs that are far
  std::vector<LeafBounds> bounds_;              // of leaves
  std::vector<uint32_t> unused_, retired_;      // halves, by the first: for others, from now on
  std::vector<SlidingPlanes::UsedUp> expired_;
  std::vector<uint32_t> looked_at_;                      // leaves
  size_t n_leaves_asked_ = 0, n_planes_asked_ = 0;       // of those that may be closed
  std::array<uint32_t, DistanceBatch::kRoom> leaves_{};  // whose triangles wait
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
  const ObbSweep* sweep_ = nullptr;  // of the motion that is followed
  TrianglePair nearest_;
  bool has_nearest_ = false;
};

}  // namespace haptic

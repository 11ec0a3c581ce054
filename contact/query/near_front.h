// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/query/box_distance.h"
#include "contact/query/near_pairs.h"

namespace haptic {

/// near_pairs from pose to pose. It remembers the front of the double descent: the pairs of nodes
/// that were too far apart to be opened, with how far at least, and in pairs of leaves that were
/// opened for each two triangles a direction along which they are apart, and how far: sliding past
/// each other uses none of it up, and where it is they are measured again. A pair is looked at
/// again when what B has travelled since may have used its slack up; pairs wait for that in buckets
/// of travel, so that the others are not even touched. Travel is counted for each part of B by
/// itself, as the sum over poses of the furthest way of a corner of the box around it: no point of
/// the part has gone further (the way is affine in the point). Siblings that are both far are
/// replaced by their parent. Fronts as in Klosowski et al. 1998 and Ehmann & Lin 2001; motion
/// bounds instead of tests on every step. Room for the corners of both meshes is made at
/// construction; that for the front and its pairs grows until it has held the largest.
class NearFront {
 public:
  /// Views of both shapes must outlive it.
  NearFront(const MeshShape& shape_A, const MeshShape& shape_B);

  /// The same set as near_pairs, in an order of its own, until the next call. A band other than
  /// before costs a pass over the front.
  std::span<const NearPair> update(const Pose& X_AB, double band);

  /// The same at the end of a motion that begins at the pose of the update before, and what may
  /// have met on the way: while no point of B is as far as half the band off the straight line
  /// between its ends, no two triangles did but the suspects. Costs more the longer the way is. Of
  /// a first update nothing is known: is_first().
  std::span<const NearPair> follow(const RigidMotion& motion, double band);
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
  static constexpr uint32_t kBuckets = 128;
  static constexpr size_t kMostParts = 64;
  static constexpr size_t kLeafPairs = kLeafTriangles * kLeafTriangles;

  enum class State : uint8_t { kUnused, kFar, kOpen, kLeaves, kReplaced };
  struct Pair {
    NodePair nodes;
    uint32_t parent = kNone;
    uint32_t below = kNone;  // open: the first of its halves; leaves: their bounds
    uint8_t part = 0;        // of B
    State state = State::kUnused;
    double until = 0;  // far: travel at which they may touch [m]
  };
  /// Of triangles 4 j + i: a direction in A along which planes between them are so far apart.
  /// Where b goes along it is gained or lost; what it does across counts for nothing.
  struct alignas(64) LeafBounds {
    std::array<float, kLeafPairs> at_least;              // [m]
    std::array<std::array<int16_t, kLeafPairs>, 3> way;  // unit vectors in steps of kWayStep
    std::array<float, 3> centre_A;                       // of the box of b where that holds
    float turned;                                        // how far B had then [rad]
    float radius;                                        // of b about its centre [m]
    float rounding;                                      // of a gap [m]
  };
  static_assert(sizeof(LeafBounds) == 192);
  /// A piece of B that travels by itself.
  struct Part {
    Vec3 centre_B, spokes_B[3];  // half axes of its box
    double travel = 0;           // [m]
    double way = 0;              // of it, since the pose before, where that is followed [m]
    int64_t bucket = 0;          // that this travel is in
    std::array<uint32_t, kBuckets> first;
  };

  void make_parts(uint32_t node, int depth);
  void begin();
  void note_travel(const Pose& X_AB);
  void change_band(double band);
  void take_expired(Part& part, int64_t last_bucket);
  void visit_expired();
  void visit(uint32_t index);
  void open(uint32_t index);
  void begin_leaves(uint32_t index);
  void look_at_leaves(uint32_t index);
  void measure_waiting();
  void leave_leaves(uint32_t index, double least);
  void raise(uint32_t index, double apart);
  void wait_far(uint32_t index, double apart);
  void put_in_bucket(uint32_t index, double travel);
  uint32_t new_halves();
  uint32_t new_bounds();
  double at_least(const NodePair& nodes);
  bool is_far(const Pair& pair, double apart) const;
  bool was_apart(size_t i, size_t corners_A, size_t corners_B) const;
  Part& part_of(const Pair& pair) { return parts_[pair.part]; }

  MeshShape shape_A_, shape_B_;
  std::vector<Corners> corners_A_, corners_B_;  // in the order of the trees
  std::vector<uint8_t> part_of_;                // of nodes of B
  std::vector<Part> parts_;
  std::vector<Pair> pairs_;     // halves of a pair side by side, the root first
  std::vector<uint32_t> next_;  // of each pair: in its bucket, or unused
  std::vector<LeafBounds> bounds_;
  std::vector<uint32_t> unused_bounds_;
  uint32_t unused_halves_ = kNone;
  std::vector<uint32_t> expired_;
  std::array<uint32_t, DistanceBatch::kRoom> leaves_{};  // whose triangles wait, in no bucket
  size_t n_leaves_ = 0;
  std::vector<NearPair> near_;
  std::vector<TrianglePair> suspects_;
  DistanceBatch batch_;
  struct Waiting {
    uint32_t pair, triangle;
  };
  std::array<Waiting, DistanceBatch::kRoom> waiting_{};
  Work work_;
  Pose X_AB_;
  BoxDistance boxes_{Pose{}};
  double band_ = 0, bucket_width_ = 0, turned_ = 0;
  bool is_fresh_ = true;
  const ObbSweep* sweep_ = nullptr;  // of the motion that is followed
  Pose X_AB_before_;
  TrianglePair nearest_;
  bool has_nearest_ = false;
};

}  // namespace haptic

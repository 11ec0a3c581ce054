// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/query/simd/lanes.h"
#include "proto/math/mat3.h"
#include "proto/math/pose.h"

namespace haptic {

/// Displacement of a mesh B in A between two poses: x_A' − x_A = way + turn x_B.
struct PoseChange {
  Vec3 way;          // displacement of B's origin [m]
  Mat3 turn;         // R_AB' − R_AB
  double angle = 0;  // upper bound of ‖R_AB' − R_AB‖, the displacement per distance from the origin
  double rounding = 0;  // of a displaced point in float, at most [m]

  PoseChange() = default;
  /// `reach`: largest distance of a point of B from its origin [m].
  PoseChange(const Pose& from_AB, const Pose& to_AB, double reach);

  Vec3 of(const Vec3& point_B) const { return way + turn * point_B; }
  /// Upper bound of the displacement of any point in a ball [m].
  double most(const Vec3& centre_B, double radius) const;
};

/// A PoseChange in float; the fourth lane is unused.
struct MovedFloats {
  Lanes way, turn[3];  // its columns
  float angle, rounding;

  explicit MovedFloats(const PoseChange& change);
  Lanes of(float x, float y, float z) const {
    return way + x * turn[0] + y * turn[1] + z * turn[2];
  }
};

/// A separating plane of a piece of A and a piece of B, with a lower bound of the gap along its
/// normal.
struct SlidingPlane {
  Vec3 normal_A;      // from A to B; length between 1 − 1e-6 and 1
  double gap = 0;     // [m]
  Vec3 centre_B;      // bounding ball of the piece of B
  double radius = 0;  // [m]
};

/// Eight planes as a structure of arrays, in float.
struct alignas(32) SlidingPlaneBlock {
  static constexpr size_t kPlanes = 8;
  using Row = std::array<float, kPlanes>;

  std::array<Row, 3> normal_A, centre_B;
  Row radius, gap;
  std::array<uint32_t, kPlanes> owner;
  uint32_t used_up = 0;  // bit k: the last move consumed the gap of plane k
};

/// Separating planes that are all moved along at once when B moves:
///   gap' = gap + n·(c' − c) − ‖R' − R‖ r,
/// with centre c and radius r of the ball. Sliding along a plane does not consume its gap, and a
/// rotation only in proportion to r. A gap below 0 carries no information. Each plane belongs to an
/// owner, given by number.
class SlidingPlanes {
 public:
  void clear();
  size_t size() const { return n_; }
  bool has(uint32_t owner) const { return owner < slot_of_.size() && slot_of_[owner] != kNone; }

  /// Adds the plane of an owner, or replaces it. The normal must be one that rounded() returns.
  void put(uint32_t owner, const SlidingPlane& plane);
  void set_gap(uint32_t owner, double gap);
  void take_out(uint32_t owner);

  double gap(uint32_t owner) const;
  /// Owner of the k-th plane; take_out() changes the order.
  uint32_t owner(size_t k) const {
    const auto slot = static_cast<uint32_t>(k);
    return block_of(slot).owner[slot % SlidingPlaneBlock::kPlanes];
  }

  struct UsedUp {
    uint32_t owner;
    std::array<float, 3> normal_A;
  };
  /// Moves all planes, and appends those whose gap is then at most `least` [m].
  void move(const PoseChange& change, double least, std::vector<UsedUp>& used_up);

  /// Prefetches what put() and take_out() need.
  void prefetch(uint32_t owner) const { __builtin_prefetch(&slot_of_[owner], 1); }

  /// The unit vector rounded to float, as it is stored.
  static Vec3 rounded(const Vec3& normal);

 private:
  static constexpr uint32_t kNone = ~0u;

  SlidingPlaneBlock& block_of(uint32_t slot) { return blocks_[slot / SlidingPlaneBlock::kPlanes]; }
  const SlidingPlaneBlock& block_of(uint32_t slot) const {
    return blocks_[slot / SlidingPlaneBlock::kPlanes];
  }

  std::vector<SlidingPlaneBlock> blocks_;  // unused lanes have an infinite gap
  uint32_t n_ = 0;
  std::vector<uint32_t> slot_of_;
};

}  // namespace haptic

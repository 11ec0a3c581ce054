// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/query/simd/lanes.h"
#include "proto/math/mat3.h"
#include "proto/math/pose.h"

namespace haptic {

/// How a mesh B has gone in A from one pose to another: x_A' − x_A = way + turn x_B.
struct PoseChange {
  Vec3 way;             // of its origin [m]
  Mat3 turn;            // R_AB' − R_AB
  double angle = 0;     // at least how far that moves any unit vector
  double rounding = 0;  // of a place in floats that goes along [m]

  PoseChange() = default;
  /// `reach`: of B from its origin [m].
  PoseChange(const Pose& from_AB, const Pose& to_AB, double reach);

  Vec3 of(const Vec3& point_B) const { return way + turn * point_B; }
  /// At least how far any point of a ball has gone [m].
  double most(const Vec3& centre_B, double radius) const;
};

/// The same in floats; the fourth lane is never looked at.
struct MovedFloats {
  Lanes way, turn[3];  // its columns
  float angle, rounding;

  explicit MovedFloats(const PoseChange& change);
  Lanes of(float x, float y, float z) const {
    return way + x * turn[0] + y * turn[1] + z * turn[2];
  }
};

/// A plane between a piece of A and a piece of B, across its normal: how far they are apart along
/// it, at least.
struct SlidingPlane {
  Vec3 normal_A;      // from A to B; a unit vector, or up to 1e-6 shorter
  double gap = 0;     // [m]
  Vec3 centre_B;      // of a ball around the piece of B
  double radius = 0;  // [m]
};

/// Eight of them side by side, in floats.
struct alignas(32) SlidingPlaneBlock {
  static constexpr size_t kPlanes = 8;
  using Row = std::array<float, kPlanes>;

  std::array<Row, 3> normal_A, centre_B;
  Row radius, gap;
  std::array<uint32_t, kPlanes> owner;
  uint32_t used_up = 0;  // a bit for each, in the last move
};

/// Many such planes, moved along all at once when B goes somewhere:
///   gap' = gap + n·(c' − c) − ‖R' − R‖ r,
/// with c the centre and r the radius of the ball. What slides along its plane uses nothing up, and
/// a turn only what the size of the piece makes of it. A gap below 0 says nothing. Each plane
/// belongs to an owner, by number.
class SlidingPlanes {
 public:
  void clear();
  size_t size() const { return n_; }
  bool has(uint32_t owner) const { return owner < slot_of_.size() && slot_of_[owner] != kNone; }

  /// Replaces the one it has. The normal is what a float makes of it: see rounded().
  void put(uint32_t owner, const SlidingPlane& plane);
  void set_gap(uint32_t owner, double gap);
  void take_out(uint32_t owner);

  double gap(uint32_t owner) const;
  /// Of the k-th, in an order that changes whenever one is taken out.
  uint32_t owner(size_t k) const {
    const auto slot = static_cast<uint32_t>(k);
    return block_of(slot).owner[slot % SlidingPlaneBlock::kPlanes];
  }

  struct UsedUp {
    uint32_t owner;
    std::array<float, 3> normal_A;
  };
  /// Appends all that are no more than `least` [m] apart at the end.
  void move(const PoseChange& change, double least, std::vector<UsedUp>& used_up);

  /// Fetches what put() and take_out() need.
  void prefetch(uint32_t owner) const { __builtin_prefetch(&slot_of_[owner], 1); }

  /// The unit vector that is kept for this one.
  static Vec3 rounded(const Vec3& normal);

 private:
  static constexpr uint32_t kNone = ~0u;

  SlidingPlaneBlock& block_of(uint32_t slot) { return blocks_[slot / SlidingPlaneBlock::kPlanes]; }
  const SlidingPlaneBlock& block_of(uint32_t slot) const {
    return blocks_[slot / SlidingPlaneBlock::kPlanes];
  }

  std::vector<SlidingPlaneBlock> blocks_;  // lanes that are not in use are infinitely far apart
  uint32_t n_ = 0;
  std::vector<uint32_t> slot_of_;
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/sliding_planes.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "contact/query/point/patch_lanes.h"
#include "contact/query/simd/lanes8.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kPlaceRounding = 1e-14;  // relative error of places in double
constexpr double kFloatRounding = 1e-6;   // relative error of a displacement in float
constexpr double kNormal = 1e-6;  // relative error of a gap: normals are shorter than 1 by as much
// ‖R' − R‖ is 1/√2 of its Frobenius norm, since both are rotations
constexpr double kSpectral = 0.70710679;

HAPTIC_INLINE Float8 row(const std::array<float, 8>& values) {
  return lanes8::load<Float8>(values);
}

HAPTIC_WIDE void move_planes(std::span<SlidingPlaneBlock> blocks, const MovedFloats& moved,
                             float least) {
  for (SlidingPlaneBlock& block : blocks) {
    const Float8 x = row(block.centre_B[0]), y = row(block.centre_B[1]), z = row(block.centre_B[2]);
    Float8 gap = (1 - 4 * lanes8::kUlp) * row(block.gap);
    gap -= moved.angle * row(block.radius) + moved.rounding;
#pragma GCC unroll 3
    for (size_t axis = 0; axis < 3; ++axis) {
      gap += row(block.normal_A[axis]) * (moved.way[axis] + moved.turn[0][axis] * x +
                                          moved.turn[1][axis] * y + moved.turn[2][axis] * z);
    }
    std::memcpy(&block.gap, &gap, sizeof gap);
    // not-a-number counts as consumed
    block.used_up = lanes8::lanes_of(~(gap > least)).bits();
  }
}

}  // namespace

MovedFloats::MovedFloats(const PoseChange& change)
    : way(to_lanes(change.way)),
      turn{to_lanes(change.turn.column(0)), to_lanes(change.turn.column(1)),
           to_lanes(change.turn.column(2))},
      angle((1 + 4 * lanes8::kUlp) * static_cast<float>(change.angle)),
      rounding((1 + 4 * lanes8::kUlp) * static_cast<float>(change.rounding)) {}

PoseChange::PoseChange(const Pose& from_AB, const Pose& to_AB, double reach)
    : way(to_AB.p - from_AB.p) {
  HAPTIC_ASSERT(reach >= 0);
  const Mat3 from = to_matrix(from_AB.q), to = to_matrix(to_AB.q);
  turn = {{to.row[0] - from.row[0], to.row[1] - from.row[1], to.row[2] - from.row[2]}};
  const double squares =
      norm_squared(turn.row[0]) + norm_squared(turn.row[1]) + norm_squared(turn.row[2]);
  angle = kSpectral * std::sqrt(squares) + kPlaceRounding;
  rounding = kPlaceRounding * (norm(from_AB.p) + norm(to_AB.p) + reach) +
             kFloatRounding * (norm(way) + angle * reach);
}

double PoseChange::most(const Vec3& centre_B, double radius) const {
  HAPTIC_ASSERT(!(radius < 0));
  return norm(of(centre_B)) + angle * radius + rounding;
}

void SlidingPlanes::clear() {
  blocks_.clear();
  slot_of_.clear();
  n_ = 0;
}

Vec3 SlidingPlanes::rounded(const Vec3& normal) {
  const Vec3 n = normalized(normal);
  return {static_cast<double>(static_cast<float>(n.x)),
          static_cast<double>(static_cast<float>(n.y)),
          static_cast<double>(static_cast<float>(n.z))};
}

void SlidingPlanes::put(uint32_t owner, const SlidingPlane& plane) {
  HAPTIC_ASSERT(is_unit(plane.normal_A));
  if (owner >= slot_of_.size()) slot_of_.resize(owner + owner / 2 + 1, kNone);
  uint32_t& slot = slot_of_[owner];
  if (slot == kNone) slot = n_++;
  if (slot / SlidingPlaneBlock::kPlanes == blocks_.size()) {
    blocks_.emplace_back();
    blocks_.back().gap.fill(lanes8::kInfinity);
  }
  SlidingPlaneBlock& block = block_of(slot);
  const size_t lane = slot % SlidingPlaneBlock::kPlanes;
  const std::array<float, 3> n = to_floats(plane.normal_A), c = to_floats(plane.centre_B);
  for (size_t axis = 0; axis < 3; ++axis) {
    block.normal_A[axis][lane] = n[axis];
    block.centre_B[axis][lane] = c[axis];
  }
  block.radius[lane] = static_cast<float>((1 + kFloatRounding) * plane.radius +
                                          kFloatRounding * norm(plane.centre_B));
  block.owner[lane] = owner;
  set_gap(owner, plane.gap);
}

void SlidingPlanes::set_gap(uint32_t owner, double gap) {
  HAPTIC_ASSERT(has(owner));
  const uint32_t slot = slot_of_[owner];
  block_of(slot).gap[slot % SlidingPlaneBlock::kPlanes] = static_cast<float>((1 - kNormal) * gap);
}

/// The last plane takes its slot.
void SlidingPlanes::take_out(uint32_t owner) {
  HAPTIC_ASSERT(has(owner));
  const uint32_t slot = slot_of_[owner], last = --n_;
  SlidingPlaneBlock &to = block_of(slot), &from = block_of(last);
  const size_t i = slot % SlidingPlaneBlock::kPlanes, k = last % SlidingPlaneBlock::kPlanes;
  for (size_t axis = 0; axis < 3; ++axis) {
    to.normal_A[axis][i] = from.normal_A[axis][k];
    to.centre_B[axis][i] = from.centre_B[axis][k];
  }
  to.radius[i] = from.radius[k];
  to.gap[i] = from.gap[k];
  to.owner[i] = from.owner[k];
  slot_of_[to.owner[i]] = slot;
  slot_of_[owner] = kNone;
  for (SlidingPlaneBlock::Row& row : from.normal_A) row[k] = 0;
  from.radius[k] = 0;
  from.gap[k] = lanes8::kInfinity;
  if (k == 0) blocks_.pop_back();
}

double SlidingPlanes::gap(uint32_t owner) const {
  HAPTIC_ASSERT(has(owner));
  const uint32_t slot = slot_of_[owner];
  return static_cast<double>(block_of(slot).gap[slot % SlidingPlaneBlock::kPlanes]);
}

void SlidingPlanes::move(const PoseChange& change, double least, std::vector<UsedUp>& used_up) {
  constexpr size_t kAtOnce = 64;  // blocks that fit in the L1 cache
  const MovedFloats moved(change);
  const float bound = round_up_distance(least);
  for (size_t first = 0; first < blocks_.size(); first += kAtOnce) {
    const std::span<SlidingPlaneBlock> some =
        std::span(blocks_).subspan(first, std::min(kAtOnce, blocks_.size() - first));
    move_planes(some, moved, bound);
    for (const SlidingPlaneBlock& block : some) {
      for (LaneSet lanes(block.used_up); lanes.any(); lanes.pop()) {
        const size_t lane = lanes.first();
        const auto& n = block.normal_A;
        used_up.push_back({block.owner[lane], {n[0][lane], n[1][lane], n[2][lane]}});
      }
    }
  }
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/query/simd/lanes.h"
#include "contact/shape/tree/hash_grid.h"

namespace haptic {

/// The part of a segment within a cell, prepared for the batches of that cell.
class CellProbe {
 public:
  CellProbe() = default;
  /// End points in cells, relative to the centre of the cell; outside it by rounding only.
  CellProbe(const Vec3& a, const Vec3& b) {
    const IntLanes from = in_units(a), to = in_units(b);
    // end points are rounded to half a unit
    const IntLanes highest = (from > to ? from : to) + 1, lowest = (from < to ? from : to) - 1;
    const IntLanes beyond[] = {highest & 0xff, -lowest & 0xff};
    const IntLanes spread_high = four_times(beyond[0]), spread_low = four_times(beyond[1]);
    bounds_[0] = bytes_of(__builtin_shufflevector(spread_high, spread_high, 0, 0, 1, 1));
    bounds_[1] = bytes_of(__builtin_shufflevector(spread_high, spread_low, 2, 2, 4, 4));
    bounds_[2] = bytes_of(__builtin_shufflevector(spread_low, spread_low, 1, 1, 2, 2));
    const IntLanes from_twice = twice(from), to_twice = twice(to);
    from_ = {broadcast<0>(from_twice), broadcast<1>(from_twice), broadcast<2>(from_twice)};
    to_ = {broadcast<0>(to_twice), broadcast<1>(to_twice), broadcast<2>(to_twice)};
  }

  /// Which triangles of the batch the segment may meet in this cell; bits as in bits_of.
  unsigned may_meet(const TriangleBatch& batch) const {
    const char* rows = reinterpret_cast<const char*>(&batch);
    const ByteLanes beside = (load_lanes<ByteLanes>(rows) > bounds_[0]) |
                             (load_lanes<ByteLanes>(rows + 16) > bounds_[1]) |
                             (load_lanes<ByteLanes>(rows + 32) > bounds_[2]);
    const auto xy = load_lanes<ByteLanes>(rows + 48), z = load_lanes<ByteLanes>(rows + 64);
    const ShortLanes nx = doubled_low(xy) >> 8, ny = doubled_high(xy) >> 8,
                     nz = doubled_low(z) >> 8;
    const ShortLanes at_from = nx * from_[0] + ny * from_[1] + nz * from_[2];
    const ShortLanes at_to = nx * to_[0] + ny * to_[1] + nz * to_[2];
    const auto nearest = load_lanes<ShortLanes>(batch.nearest.data());
    const auto furthest = load_lanes<ShortLanes>(batch.furthest.data());
    const ShortLanes off_slab =
        ((at_from < nearest) & (at_to < nearest)) | ((at_from > furthest) & (at_to > furthest));
    return bits_of(~(off_slab | doubled_low(beside) | doubled_high(beside)));
  }

 private:
  static IntLanes in_units(const Vec3& v) {
    const Lanes cells{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0};
    // truncation rounds down once the value is positive
    constexpr int kUp = 2 * kCellUnits;
    return __builtin_convertvector(cells * (2 * kCellUnits) + (kUp + 0.5f), IntLanes) - kUp;
  }
  static ByteLanes bytes_of(IntLanes v) { return load_lanes<ByteLanes>(&v); }
  /// Each byte copied to all four places.
  static IntLanes four_times(IntLanes v) {
    const IntLanes pair = v | (v << 8);
    return pair | (pair << 16);
  }
  /// Each as a pair of 16-bit integers.
  static IntLanes twice(IntLanes v) { return (v & 0xffff) | (v << 16); }
  template <int kLane>
  static ShortLanes broadcast(IntLanes v) {
    const IntLanes all = __builtin_shufflevector(v, v, kLane, kLane, kLane, kLane);
    return load_lanes<ShortLanes>(&all);
  }

  std::array<ByteLanes, 3> bounds_;  // x y, z −x, −y −z: same layout as the rows of a batch
  std::array<ShortLanes, 3> from_, to_;
};

/// Traversal of the cells along a segment (3-D DDA; Amanatides & Woo 1987).
class CellWalk {
 public:
  /// False if the segment leaves the index range of the grid or would cross too many cells.
  bool start(const HashGrid& grid, const Vec3& from_O, const Vec3& d_O) {
    p_ = grid.cells_per_metre * (from_O - grid.lower_O);
    d_ = grid.cells_per_metre * d_O;
    const Vec3 q = p_ + d_;
    constexpr double kIndices = 1 << kGridBits;
    if (!(std::min({p_.x, p_.y, p_.z, q.x, q.y, q.z}) >= 0) ||
        !(std::max({p_.x, p_.y, p_.z, q.x, q.y, q.z}) < kIndices)) {
      return false;
    }
    index_ = {static_cast<int32_t>(p_.x), static_cast<int32_t>(p_.y), static_cast<int32_t>(p_.z)};
    const std::array<int32_t, 3> last{static_cast<int32_t>(q.x), static_cast<int32_t>(q.y),
                                      static_cast<int32_t>(q.z)};
    crossings_ = std::abs(last[0] - index_[0]) + std::abs(last[1] - index_[1]) +
                 std::abs(last[2] - index_[2]);
    exit_ = {kNever, kNever, kNever};
    if (crossings_ == 0) return true;
    for (size_t i = 0; i < 3; ++i) {
      const int axis = static_cast<int>(i);
      const bool down = d_[axis] < 0, still = last[i] == index_[i];
      const double per_d = 1 / d_[axis];
      step_[i] = down ? -1 : 1;
      per_step_[i] = std::fabs(per_d);
      exit_[i] = still ? kNever : (index_[i] + (down ? 0 : 1) - p_[axis]) * per_d;
    }
    return crossings_ <= kMostCrossings;
  }

  uint64_t key() const { return cell_key(index_); }

  /// Fraction of the segment at which it leaves this cell.
  double exit() const { return std::min({exit_[0], exit_[1], exit_[2], 1.0}); }

  /// The part within this cell, up to fraction `end` of the segment.
  CellProbe probe(double end) const {
    const Vec3 centre{index_[0] + 0.5, index_[1] + 0.5, index_[2] + 0.5};
    return {(p_ - centre) + entry_ * d_, (p_ - centre) + std::min(exit(), end) * d_};
  }

  /// Goes to the next cell; false at the end.
  bool advance() {
    if (crossings_-- == 0) return false;
    entry_ = exit();
    // branch-free: which border comes next is unpredictable
    const bool x = exit_[0] <= exit_[1] && exit_[0] <= exit_[2];
    const bool y = !x && exit_[1] <= exit_[2];
    const std::array<bool, 3> crossed{x, y, !x && !y};
    for (size_t i = 0; i < 3; ++i) {
      index_[i] += crossed[i] ? step_[i] : 0;
      exit_[i] += crossed[i] ? per_step_[i] : 0;
    }
    return true;
  }

 private:
  static constexpr double kNever = 2;        // beyond the segment, which ends at 1
  static constexpr int kMostCrossings = 64;  // longer segments are faster through the tree

  Vec3 p_, d_;  // in cells, from the corner of the grid
  double entry_ = 0;
  int crossings_;  // borders left to cross
  std::array<int32_t, 3> index_, step_;
  std::array<double, 3> exit_, per_step_;
};

}  // namespace haptic

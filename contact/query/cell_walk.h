// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "contact/query/lanes.h"
#include "contact/shape/hash_grid.h"

namespace haptic {

/// The part of a segment within a cell, for the batches of that cell.
class CellProbe {
 public:
  /// Ends in cells from the centre of the cell; beyond its borders by rounding only.
  CellProbe(const Vec3& a, const Vec3& b) {
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<size_t>(i);
      a_[axis] = in_units(a[i]);
      b_[axis] = in_units(b[i]);
    }
  }

  /// Which triangles of the batch the segment may meet in this cell: byte i is 1 or 0.
  uint64_t may_meet(const TriangleBatch& batch) const {
    ShortLanes apart{}, at_a{}, at_b{};
    for (size_t i = 0; i < 3; ++i) {
      // an end is rounded to half a unit
      const auto lowest = static_cast<int16_t>(std::min(a_[i], b_[i]) - 1);
      const auto highest = static_cast<int16_t>(std::max(a_[i], b_[i]) + 1);
      apart |= (load_widened(batch.lower[i].data()) > highest) |
               (load_widened(batch.upper[i].data()) < lowest);
      const ShortLanes normal = load_widened(batch.normal[i].data());
      at_a += normal * a_[i];
      at_b += normal * b_[i];
    }
    const auto nearest = load_lanes<ShortLanes>(batch.nearest.data());
    const auto furthest = load_lanes<ShortLanes>(batch.furthest.data());
    apart |= ((at_a < nearest) & (at_b < nearest)) | ((at_a > furthest) & (at_b > furthest));
    const ByteLanes meet = __builtin_convertvector(~apart, ByteLanes);
    return load_lanes<uint64_t>(&meet) & 0x0101010101010101;
  }

 private:
  static int16_t in_units(double value) {
    // to truncate what is positive is to round down
    constexpr int kUp = 2 * kCellUnits;
    return static_cast<int16_t>(static_cast<int>(value * (2 * kCellUnits) + (kUp + 0.5)) - kUp);
  }

  std::array<int16_t, 3> a_, b_;
};

/// Walk from cell to cell along a segment (3-D DDA; Amanatides & Woo 1987).
class CellWalk {
 public:
  /// False where the segment leaves the indices of the grid or would cross too many cells.
  bool start(const HashGrid& grid, const Vec3& from_O, const Vec3& d_O) {
    const double per_cell = 1 / grid.cell;
    p_ = per_cell * (from_O - grid.lower_O);
    d_ = per_cell * d_O;
    const Vec3 q = p_ + d_;
    constexpr double kIndices = 1 << kGridBits;
    if (!(std::min({p_.x, p_.y, p_.z, q.x, q.y, q.z}) >= 0) ||
        !(std::max({p_.x, p_.y, p_.z, q.x, q.y, q.z}) < kIndices)) {
      return false;
    }
    index_ = {static_cast<int32_t>(p_.x), static_cast<int32_t>(p_.y), static_cast<int32_t>(p_.z)};
    const std::array<int32_t, 3> last{static_cast<int32_t>(q.x), static_cast<int32_t>(q.y),
                                      static_cast<int32_t>(q.z)};
    if (index_ == last) return true;
    for (size_t i = 0; i < 3; ++i) {
      const int32_t cells = last[i] - index_[i];
      left_[i] = std::abs(cells);
      if (cells == 0) continue;
      const double per_d = 1 / d_[static_cast<int>(i)];
      step_[i] = cells < 0 ? -1 : 1;
      per_step_[i] = std::fabs(per_d);
      exit_[i] = (index_[i] + (cells > 0 ? 1 : 0) - p_[static_cast<int>(i)]) * per_d;
    }
    return left_[0] + left_[1] + left_[2] <= kMostCrossings;
  }

  uint64_t key() const { return cell_key(index_); }

  /// Where along the segment this cell ends.
  double exit() const { return std::min({exit_[0], exit_[1], exit_[2], 1.0}); }

  /// The part in this cell.
  CellProbe probe() const {
    const Vec3 centre{index_[0] + 0.5, index_[1] + 0.5, index_[2] + 0.5};
    return {(p_ - centre) + entry_ * d_, (p_ - centre) + exit() * d_};
  }

  /// On to the next cell; false at the end.
  bool advance() {
    const size_t axis = exit_[0] <= exit_[1] && exit_[0] <= exit_[2] ? 0
                        : exit_[1] <= exit_[2]                       ? 1
                                                                     : 2;
    if (left_[axis] == 0) return false;
    entry_ = exit();
    index_[axis] += step_[axis];
    exit_[axis] = --left_[axis] > 0 ? exit_[axis] + per_step_[axis] : kNever;
    return true;
  }

 private:
  static constexpr double kNever = 2;
  static constexpr int kMostCrossings = 64;  // a longer way is shorter through the tree

  Vec3 p_, d_;  // in cells, from the corner of the grid
  double entry_ = 0;
  std::array<int32_t, 3> index_{}, step_{}, left_{};
  std::array<double, 3> exit_{kNever, kNever, kNever}, per_step_{};
};

}  // namespace haptic

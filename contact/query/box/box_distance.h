// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/simd/lanes.h"
#include "contact/shape/tree/obb_tree.h"
#include "proto/math/pose.h"

namespace haptic {

/// Lower bound of the distance of boxes of two trees, with B at X_AB in A: the largest gap along
/// the 15 separating axes of Gottschalk, Lin, Manocha 1996, with the face axes of each box combined
/// (the distance to the axis-aligned box, in its frame, around the other). Computed in float once
/// the boxes' relative position is known; never more than the distance of what they contain.
class BoxDistance {
 public:
  explicit BoxDistance(const Pose& X_AB);

  /// [m], 0 if unknown.
  double at_least(const CompactObb& a, const CompactObb& b) const;

  /// The lower bound, and a direction from A to B, expressed in A and not normalised, along which
  /// they are about that far apart; 0 if they are not apart.
  struct Separation {
    double at_least = 0;  // [m]
    Vec3 way_A;
  };
  Separation separation(const CompactObb& a, const CompactObb& b) const;

  /// Gap along a unit vector in A, at least [m]; negative if they overlap.
  double along(const Vec3& normal_A, const CompactObb& a, const CompactObb& b) const;

 private:
  struct Gaps;
  Vec3 way_between(const CompactObb& a, const CompactObb& b) const;
  double rounding_of(const CompactObb& a, const CompactObb& b) const;
  Gaps gaps(const CompactObb& a, const CompactObb& b) const;

  Mat3 R_AB_;
  Vec3 p_AB_;
  Lanes columns_AB_[3];
  double rounding_;  // of positions in double [m]
};

}  // namespace haptic

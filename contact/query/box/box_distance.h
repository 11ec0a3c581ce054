// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/simd/lanes.h"
#include "contact/shape/tree/obb_tree.h"
#include "proto/math/pose.h"

namespace haptic {

/// How far boxes of two trees are apart at least, with B at X_AB in A: the largest gap along the 15
/// separating axes of Gottschalk, Lin, Manocha 1996, those along the faces of one box taken
/// together (the distance to the upright box around the other). In floats from what the boxes have
/// of them on, and never more than the distance of what they hold.
class BoxDistance {
 public:
  explicit BoxDistance(const Pose& X_AB);

  /// [m], 0 where nothing is known.
  double at_least(const CompactObb& a, const CompactObb& b) const;

  /// The same, and a direction in A in which they are about that far apart: of any length, from A
  /// to B; 0 where they are not.
  struct Separation {
    double at_least = 0;  // [m]
    Vec3 way_A;
  };
  Separation separation(const CompactObb& a, const CompactObb& b) const;

  /// How far they are apart along a unit vector in A, at least [m]; negative where they overlap.
  double along(const Vec3& normal_A, const CompactObb& a, const CompactObb& b) const;

 private:
  struct Gaps;
  Vec3 way_between(const CompactObb& a, const CompactObb& b) const;
  double rounding_of(const CompactObb& a, const CompactObb& b) const;
  Gaps gaps(const CompactObb& a, const CompactObb& b) const;

  Mat3 R_AB_;
  Vec3 p_AB_;
  Lanes columns_AB_[3];
  double rounding_;  // of places in double [m]
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/lanes.h"
#include "contact/shape/obb_tree.h"
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

 private:
  Mat3 R_AB_;
  Vec3 p_AB_;
  Lanes columns_AB_[3];
  double rounding_;  // of places in double [m]
};

}  // namespace haptic

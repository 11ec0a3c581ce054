// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "proto/math/motion_metric.h"
#include "proto/wire/guide.h"
#include "servo/solve/carried_contacts.h"

namespace haptic {

/// The guide rows of a set (proto/wire/guide.h), which all belong to one object. A view of the set.
struct GuideRows {
  std::span<const GuideRow> rows;
  uint32_t object = kMaxObjects;  // kMaxObjects: there are none
};

/// None where a row is not finite, or they are of several objects.
GuideRows guide_rows(const ContactSet& set);

/// The pose nearest to the hand that satisfies all rows as equations, with their object at X_WO:
///   argmin ½ aᵀ K a  s.t.  n_k·(tool point_k − object point_k) = 0,  a the way from X_WT.
/// The springs K then pull with Jᵀλ, λ of either sign. Rows are linear in a small motion only, so
/// that the pose is found by Newton's method from `start`, the last tick's: at each pose X the
/// least a that satisfies the rows J_k = (n_k, r_k × n_k) there, by the orthonormal basis of the
/// rows in the coordinates of the metric; rows that depend on others are left out. Three rows at
/// the tool's origin are met by the first step. Six converge quadratically to the solution that
/// belongs to the start (turned by more than a right angle there are others); of fewer, which leave
/// turns free, the way along them converges linearly, from tick to tick.
Pose nearest_on_guides(const GuideRows& guides, const Pose& X_WO, const Pose& X_WT,
                       const Pose& start, const MotionMetric& metric);

}  // namespace haptic

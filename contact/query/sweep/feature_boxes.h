// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/query/sweep/feature_path.h"

namespace haptic {

struct BoxSearch {
  double time = 0;            // the features are apart at every earlier time
  bool may_meet = false;      // false: they are apart along the whole path
  bool is_exhausted = false;  // the budget or the room ended the search
};

/// The first time, from `from` on, at which F(t, u, v) = 0 may hold. Between two times F is affine
/// in each of its three variables, so its values at the corners of a box bound it. Bisects the
/// variable that F changes most with, earliest box first, until F excludes 0 or is smaller than the
/// tolerance throughout (inclusion-based root finding in three variables after Snyder 1992, Wang et
/// al. 2021). Rounding is added term by term. A box is excluded along the three axes, or along the
/// common normal of both features half-way. Evaluates at most `budget` boxes; allocates nothing.
BoxSearch first_box(const FeaturePath& path, double from, double tolerance, uint32_t budget);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "contact/query/sweep/feature_path.h"

namespace haptic {

struct BoxSearch {
  double time = 0;            // the features are apart at any time before
  bool may_meet = false;      // false: they are apart all the way
  bool is_exhausted = false;  // the budget or the room has ended the search
};

/// When F(t, u, v) = 0 may be, from a time on. Between two times F is affine in each of its three
/// variables, so that over a box its corners bound it. Boxes are halved across the variable that F
/// changes most with, earliest first, until 0 is outside, or F is smaller than the tolerance
/// throughout (inclusion of three variables after Snyder 1992, Wang et al. 2021). Rounding is added
/// term by term. Apart is told along the three axes and along the normal of both features half-way.
/// Looks at no more boxes than the budget; allocates nothing.
BoxSearch first_box(const FeaturePath& path, double from, double tolerance, uint32_t budget);

}  // namespace haptic

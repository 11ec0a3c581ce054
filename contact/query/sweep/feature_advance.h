// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/sweep/feature_path.h"

namespace haptic {

/// u and v that minimise |base − u e − v f|: the closest points of the two features.
std::array<double, 2> closest_of(const Slice& slice, bool is_triangle);

struct Advance {
  enum class End { kApart, kNear, kUnknown };  // the whole way; within the tolerance; undecided

  double time = 0;  // the features are apart at every earlier time
  End end = End::kUnknown;
};

/// Advances along the path as far as the features are proven apart. At time t the direction n
/// between their closest points separates them as long as min n·F exceeds rounding and the bend of
/// the path; within a step min n·F is at least its linear interpolation, so the step may go to
/// where that vanishes. Close to a meeting the steps shrink as those of Newton's method do, and
/// never pass it. Conservative advancement (Mirtich 1996) with the motion along n in place of a
/// speed bound. At most 48 steps. Features nearer than the tolerance at the start may come half as
/// near: so they can separate or slide.
Advance advance(const FeaturePath& path, double tolerance);

}  // namespace haptic

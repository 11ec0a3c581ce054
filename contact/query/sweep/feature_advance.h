// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/sweep/feature_path.h"

namespace haptic {

/// u and v at which |base − u e − v f| is least: the closest points of the two features.
std::array<double, 2> closest_of(const Slice& slice, bool is_triangle);

struct Advance {
  enum class End { kApart, kNear, kUnknown };  // all the way, to the tolerance, cut short

  double time = 0;  // the features are apart at any time before
  End end = End::kUnknown;
};

/// Goes along the path as far as the features are sure to be apart. From a time t the direction n
/// of their closest points keeps them apart as long as min n·F stays above what rounding and the
/// bend of the way allow for; between the ends of a step it is at least on the line between its
/// values there, so that the step may go to where that line ends. On the last stretch to a meeting
/// the steps shrink as Newton's do; they never pass it. Conservative advancement (Mirtich 1996)
/// with the motion along n in place of its speed. At most 48 steps. What is nearer than the
/// tolerance at the beginning of the path may come half as near: it can leave, and slide along.
Advance advance(const FeaturePath& path, double tolerance);

}  // namespace haptic

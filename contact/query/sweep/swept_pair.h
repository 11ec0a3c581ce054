// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "contact/query/sweep/feature_path.h"

namespace haptic {

/// When two features may first meet.
struct SweptMeeting {
  double time = 0;         // they are apart at every earlier time: never late
  bool is_proven = false;  // they are within the tolerance there; else nothing more is known
};

/// First meeting of a vertex and a face; nullopt proves that they do not meet. Advances as far as
/// they are proven apart (feature_advance.h): features that come within the tolerance [m], or
/// within half their distance at the start of the stretch where that is less, count as meeting.
/// Bounded; allocates nothing.
std::optional<SweptMeeting> vertex_face_meeting(const SweptPoint& vertex,
                                                const std::array<SweptPoint, 3>& face,
                                                double tolerance);

/// First meeting of two edges; parallel ones need no special case.
std::optional<SweptMeeting> edge_edge_meeting(const std::array<SweptPoint, 2>& a,
                                              const std::array<SweptPoint, 2>& b, double tolerance);

/// First meeting of any two features, as of a rigid tool with fixed ones of an object, with times
/// of the whole motion. Between two times a point deviates from the straight line by an amount that
/// depends on its distance from the centre; half the time gives a quarter of it.
std::optional<SweptMeeting> first_meeting(const FeaturePath& path, double tolerance);

}  // namespace haptic

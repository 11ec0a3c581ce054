// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "contact/query/sweep/feature_path.h"

namespace haptic {

struct SweptPairOptions {
  // features nearer than this, or than half their distance at the start of the stretch, may count
  // as meeting [m]
  double tolerance = 1e-6;
  // most boxes of (t, u, v) to distinguish a near miss from a meeting; 0: whatever comes within the
  // tolerance meets
  uint32_t budget = 0;
};

/// When two features may first meet.
struct SweptMeeting {
  double time = 0;         // they are apart at every earlier time: never late
  bool is_proven = false;  // they are within the tolerance there; else the search was cut short
};

/// First meeting of a vertex and a face; nullopt proves that they do not meet. Advances as far as
/// they are proven apart (feature_advance.h); where that ends close to contact, bisection over time
/// and place decides if there is a budget (feature_boxes.h). Bounded; allocates nothing.
std::optional<SweptMeeting> vertex_face_meeting(const SweptPoint& vertex,
                                                const std::array<SweptPoint, 3>& face,
                                                const SweptPairOptions& options);

/// The same for two edges; parallel ones need no special case.
std::optional<SweptMeeting> edge_edge_meeting(const std::array<SweptPoint, 2>& a,
                                              const std::array<SweptPoint, 2>& b,
                                              const SweptPairOptions& options);

/// The same for features of a rigid tool that moves past fixed ones of an object, in O, with times
/// of the whole motion. Between two times a point deviates from the straight line by an amount that
/// depends on its distance from the centre; half the time gives a quarter of it.
std::optional<SweptMeeting> vertex_face_meeting(const MotionStretch& stretch, const Vec3& vertex_T,
                                                const std::array<Vec3, 3>& face_O,
                                                const SweptPairOptions& options);
std::optional<SweptMeeting> face_vertex_meeting(const MotionStretch& stretch,
                                                const std::array<Vec3, 3>& face_T,
                                                const Vec3& vertex_O,
                                                const SweptPairOptions& options);
std::optional<SweptMeeting> edge_edge_meeting(const MotionStretch& stretch,
                                              const std::array<Vec3, 2>& edge_T,
                                              const std::array<Vec3, 2>& edge_O,
                                              const SweptPairOptions& options);

}  // namespace haptic

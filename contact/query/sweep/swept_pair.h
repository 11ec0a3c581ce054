// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "contact/query/sweep/feature_path.h"

namespace haptic {

struct SweptPairOptions {
  // nearer than this, and than half of what it was where the stretch begins, may count as meeting
  // [m]
  double tolerance = 1e-6;
  // boxes of time and place looked at to tell what only comes near from what meets; 0: what comes
  // as near as the tolerance meets
  uint32_t budget = 0;
};

/// When two features may first meet.
struct SweptMeeting {
  double time = 0;         // they are apart at any time before: never late
  bool is_proven = false;  // they are within the tolerance of each other there; else the search was
                           // cut short
};

/// A vertex and a face, where they may meet: none is a proof that they do not. First they are
/// advanced as far as they are sure to be apart (feature_advance.h); where that ends near, boxes of
/// time and place tell whether they meet, if there is a budget (feature_boxes.h). Bounded,
/// allocates nothing.
std::optional<SweptMeeting> vertex_face_meeting(const SweptPoint& vertex,
                                                const std::array<SweptPoint, 3>& face,
                                                const SweptPairOptions& options);

/// The same of two edges; parallel ones are no special case.
std::optional<SweptMeeting> edge_edge_meeting(const std::array<SweptPoint, 2>& a,
                                              const std::array<SweptPoint, 2>& b,
                                              const SweptPairOptions& options);

/// The same of features of a rigid tool that moves past still ones of an object, in O, with times
/// of the whole motion. Between two times a point is off the straight line by what its distance
/// from the centre allows; halving time makes that four times smaller.
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

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "contact/query/sweep/swept_pair.h"
#include "contact/query/triangle/triangles_meet.h"
#include "contact/shape/mesh/feature_owners.h"

namespace haptic {

/// A triangle of the tool along a stretch of its motion.
struct SweptTriangle {
  Corners corners_T;
  Corners from_O, to_O;  // at the ends of the stretch
  double off = 0;        // how far a point may be off the straight way between them [m]
};

SweptTriangle swept(const Corners& corners_T, const MotionStretch& stretch);

/// False: the triangles do not meet along the stretch, told by an axis of space or by the plane of
/// either triangle.
bool may_meet(const SweptTriangle& tool, const Corners& face_O);

/// Which of the features of two triangles are asked about, three vertices and three edges each.
struct AskedFeatures {
  const FeatureOwners &tool, &object;
  uint32_t triangle_T, triangle_O;
};

/// First meeting of a triangle of the tool with one of the object, among the features the two
/// answer for: each vertex with the other's face, each edge with each edge.
std::optional<SweptMeeting> first_meeting(const MotionStretch& stretch, const SweptTriangle& tool,
                                          const Corners& face_O, const AskedFeatures& asked,
                                          const SweptPairOptions& options);

}  // namespace haptic

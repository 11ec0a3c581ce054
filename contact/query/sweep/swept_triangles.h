// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "contact/query/sweep/swept_pair.h"
#include "contact/query/triangle/triangles_meet.h"
#include "contact/shape/mesh/feature_owners.h"

namespace haptic {

/// A triangle of the tool over a stretch of its motion.
struct SweptTriangle {
  Corners corners_T;
  Corners from_O, to_O;  // at the ends of the stretch
  double off = 0;        // deviation of a point from the straight line between them, at most [m]
};

SweptTriangle swept(const Corners& corners_T, const MotionStretch& stretch);

/// False: a coordinate axis or the normal of either triangle separates them along the whole
/// stretch.
bool may_meet(const SweptTriangle& tool, const Corners& face_O);

/// Which features of two triangles are tested here: each vertex and edge belongs to one triangle of
/// its mesh (Curtis, Tamstorf, Manocha 2008).
struct AskedFeatures {
  const FeatureOwners &tool, &object;
  uint32_t triangle_T, triangle_O;
};

/// First meeting of a triangle of the tool with one of the object, over the features that the two
/// own: each vertex with the other's face, each edge with each edge.
std::optional<SweptMeeting> first_meeting(const MotionStretch& stretch, const SweptTriangle& tool,
                                          const Corners& face_O, const AskedFeatures& asked,
                                          double tolerance);

}  // namespace haptic

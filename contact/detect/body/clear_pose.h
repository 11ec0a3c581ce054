// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "contact/query/proximity/mesh_distance.h"
#include "proto/wire/wire.h"

namespace haptic {

/// An object, and how far in front of its surface it begins to push [m].
struct PushingObject {
  MeshShape shape;
  double layer = 0;
};

/// A tool among objects; constant after start.
struct ClearanceModel {
  MeshShape tool;
  ToolBody body{};
  double least = 0;  // a clearance below this is of no use [m]
  std::vector<PushingObject> objects;
};

/// The nearest pair of triangles of each object, from which the next query begins.
using ClearanceState = std::vector<std::optional<TrianglePair>>;

/// A clearance is at least so much of what there is.
inline constexpr double kLeastShare = 0.9;

/// A pose of the tool, and how far a point of it has to move against each object before that may
/// push it [m]; 0: not known.
struct ClearPose {
  Pose X_WT;
  std::array<double, kMaxObjects> clearance{};
};

/// From a pose outside all objects towards another, as far as a few steps go, each no longer than
/// the distance of the surfaces where it begins: so nothing is passed on the way, though what is in
/// front of a surface may push (conservative advancement, Mirtich 1996). The answer is the last of
/// these poses at which nothing does. Moves the centre of mass on a straight line and turns about
/// it at one rate; largest_travel bounds how far a point goes. Distances are lower bounds by
/// mesh_distance, at least kLeastShare of what they are where a few thousand boxes tell; 0.5 m
/// stand for all that is further.
ClearPose clear_pose(const ClearanceModel& model, ClearanceState& state, std::span<const Pose> X_WO,
                     const Pose& from, const Pose& to);

}  // namespace haptic

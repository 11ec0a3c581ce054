// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "contact/query/proximity/mesh_distance.h"
#include "proto/wire/per_object.h"

namespace haptic {

/// An object, and the distance from its surface at which it begins to push [m].
struct PushingObject {
  MeshShape shape;
  double layer = 0;
};

/// A tool among objects; constant after start.
struct ClearanceModel {
  MeshShape tool;
  ToolBody body{};
  double least = 0;  // clearances below this are useless [m]
  std::vector<PushingObject> objects;
};

/// The nearest pair of triangles of each object: warm start of the next query.
using ClearanceState = std::vector<std::optional<TrianglePair>>;

/// A clearance is at least this share of the actual distance.
inline constexpr double kLeastShare = 0.9;

/// A pose of the tool, and how far a point of it has to move relative to each object before that
/// may push it [m]; 0: unknown.
struct ClearPose {
  Pose X_WT;
  PerObject<double> clearance;
};

/// Advances from a pose outside all objects towards another by a few steps, each no longer than the
/// distance of the surfaces at its start, so no surface is passed; but the layer in front of a
/// surface may be entered (conservative advancement, Mirtich 1996). Returns the last of these poses
/// at which nothing pushes. The centre of mass moves linearly, and the tool rotates about it at
/// constant rate; largest_travel bounds the motion of any point. Distances are lower bounds by
/// mesh_distance, at least kLeastShare of the actual ones if a few thousand box tests suffice, and
/// at most 0.5 m.
ClearPose clear_pose(const ClearanceModel& model, ClearanceState& state, std::span<const Pose> X_WO,
                     const Pose& from, const Pose& to);

}  // namespace haptic

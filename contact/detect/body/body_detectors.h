// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/detect/body/clear_pose.h"
#include "contact/detect/body/exact.h"
#include "contact/detect/body/voxel.h"
#include "proto/config/config.h"

namespace haptic {

/// What the detectors of renderers with six degrees of freedom need; constant after start. Not to
/// be copied: the voxel detector looks at `volumes` here.
struct BodyModel {
  BodyModel() = default;
  BodyModel(BodyModel&&) = default;
  BodyModel& operator=(BodyModel&&) = default;

  MeshShape tool;
  ToolBody body{};  // mass 0: there is no tool
  std::vector<VoxelObject> volumes;
  VoxelModel voxel;
  ClearanceModel clearance;  // of the voxel detector
  ExactOptions exact;

  bool has_tool() const { return body.mass > 0; }
  bool has_maps() const { return has_tool() && !volumes.empty(); }
};

/// The look-ahead of a tool that rests [m].
inline constexpr double kLeastBodyReach = 20e-6;

/// The voxel detector as a session has it, without objects.
VoxelModel voxel_model(const VoxelConfig& config, const Pointshell& shell);

BodyModel build_body_model(const SessionConfig& config, const BodyShapes& shapes,
                           std::span<const MeshShape> objects);

/// What survives a step, and its room: nothing is allocated later.
struct BodyState {
  BodyState() = default;
  explicit BodyState(const BodyModel& model);

  std::optional<VoxelState> voxel;
  ClearanceState clearance;
  std::vector<TrianglePair> pairs;
  std::vector<PointPush> pushes;
};

/// The contacts of a tool with the objects, by the detector of `renderer`: direct6 (all triangles
/// that meet, in clusters) or voxel. Voxel tells too how far from these contacts there is nothing
/// that pushes: of the tool where it is, or as far as a free way leads towards the hand at X_WH
/// (clear_pose). False where the session has no tool or no maps for it:
/// the set stays as it is.
bool detect_bodies(const BodyModel& model, std::span<const MeshShape> objects, Renderer renderer,
                   BodyState& state, const VoxelQuestion& question, const Pose& X_WH,
                   ContactSet& set);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/detect/body/clear_pose.h"
#include "contact/detect/body/exact.h"
#include "contact/detect/body/pieces.h"
#include "contact/detect/body/voxel.h"
#include "proto/config/config.h"

namespace haptic {

/// Constant data of the detectors for 6-DoF renderers. Not copyable: voxel.objects views `volumes`.
struct BodyModel {
  BodyModel() = default;
  BodyModel(BodyModel&&) = default;
  BodyModel& operator=(BodyModel&&) = default;

  MeshShape tool;
  ToolBody body{};  // mass 0: no tool
  std::vector<VoxelObject> volumes;
  VoxelModel voxel;
  ClearanceModel clearance;  // for the voxel detector
  ExactOptions exact;
  PieceModel pieces;

  bool has_tool() const { return body.mass > 0; }
  bool has_maps() const { return has_tool() && !volumes.empty(); }
};

/// The voxel detector's options from a session's config, without objects.
VoxelModel voxel_model(const VoxelConfig& config, const Pointshell& shell);

/// The options of the detector of convex pieces from a session's config, with the pieces.
PieceModel piece_model(const SessionConfig& config, const BodyShapes& shapes, const ToolBody& body);

BodyModel build_body_model(const SessionConfig& config, const BodyShapes& shapes,
                           std::span<const MeshShape> objects);

/// State that survives a step, and its buffers: nothing is allocated later.
struct BodyState {
  BodyState() = default;
  explicit BodyState(const BodyModel& model);

  std::optional<VoxelState> voxel;
  ClearanceState clearance;
  std::vector<TrianglePair> pairs;
  std::vector<PointPush> pushes;
  std::vector<ClusterMemory> clusters;  // of each object, from triangles
};

/// The contacts of a tool with the objects by the detector of `renderer`: direct6 (all triangles
/// that meet, clustered) or voxel. Voxel also reports the clearance beyond these contacts, for the
/// tool where it is or as far as a free path leads towards the hand at X_WH (clear_pose). False,
/// with the set unchanged, if the session has no tool or no maps for it.
bool detect_bodies(const BodyModel& model, std::span<const MeshShape> objects, Renderer renderer,
                   BodyState& state, const VoxelQuestion& question, const Pose& X_WH,
                   ContactSet& set);

}  // namespace haptic

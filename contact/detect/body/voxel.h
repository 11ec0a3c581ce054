// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/detect/body/body_question.h"
#include "contact/detect/body/shell_pushes.h"
#include "contact/shape/baked/contact_shapes.h"
#include "proto/config/config.h"

namespace haptic {

/// How the depth of a point is computed.
enum class VoxelForce : uint32_t {
  kField = 0,         // the distance field (Barbič & James 2008)
  kTangentPlanes = 1  // centres of surface voxels (McNeely, Puterbaugh, Troy 1999)
};

/// Constant data of the detector.
struct VoxelModel {
  Pointshell shell;  // of the tool, in T
  std::span<const VoxelObject> objects;
  VoxelForce reading = VoxelForce::kField;
  ShellForce force;
  ClusterOptions clusters;
  uint32_t budget = 0xffffffff;  // points looked up per step; for distance fields only
  double damping = 0;            // of approaching points, against their velocity [N·s/m]
  Braking braking = Braking::kAlongVelocity;
  double trust_radius = 1e-3;  // of the linearised wrench [m]
};

/// The options of a session's config, without objects.
VoxelModel voxel_model(const VoxelConfig& config, const Pointshell& shell);

/// Largest distance from the surface of an object at which a point can be pushed [m]: the offset,
/// plus the error of a cell or a voxel.
double push_layer(const VoxelModel& model, const VoxelObject& object, bool is_sheet);

/// State that survives a step, and its buffers: nothing is allocated later.
struct VoxelState {
  explicit VoxelState(const VoxelModel& model);

  std::vector<ShellCoherence> coherence;  // of each object
  std::vector<ShellVisit> visited;
  std::vector<ShellTouch> touches;
  std::vector<VoxelHit> hits;
  std::vector<PointPush> pushes;
  std::vector<ClusterMemory> clusters;  // of each object
  uint64_t tested = 0;                  // points looked up in the last step
  uint64_t touching = 0;                // points inside an object in the last step
  bool is_outside = true;  // no point can be inside a real surface, though some may be in its layer
};

/// The voxmap–pointshell detector. Fills in the contacts of the set (clusters of the points that
/// touch, then of those that approach; those of wrench_object first), and F0, K, B of all points
/// that touch the object that is pressed hardest. A point pushes along its own inward normal; the
/// object's normal, from its field, is the contact's shading normal, and clusters that push across
/// or against it are in F0 and K only: as springs they would outlast the touch. A contact's extent
/// is how far the object continues along its plane. Sets kContactTruncated if there was no room,
/// kContactIterationLimit if the budget ended.
void detect_voxel(const VoxelModel& model, VoxelState& state, const BodyQuestion& question,
                  ContactSet& set);

}  // namespace haptic

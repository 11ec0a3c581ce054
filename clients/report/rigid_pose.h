// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/baked/mesh_shape.h"
#include "proto/math/pose.h"

namespace haptic {

/// Checks poses of a tool that must never enter an object, each one from scratch. It shares with
/// the detector only the meshes and the triangle-triangle distance: no state, no choice of
/// contacts.
class RigidPoseJudge {
 public:
  /// Keeps views of the shapes, which must outlive it.
  RigidPoseJudge(const MeshShape& object, const MeshShape& tool);

  /// True if the surfaces intersect (exact test) or one closed body contains the other.
  bool is_entered(const Pose& X_OT) const;

 protected:
  MeshShape object_, tool_;

 private:
  std::vector<Vec3> object_points_, tool_points_;  // one point of each shell
};

}  // namespace haptic

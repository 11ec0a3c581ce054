// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/rigid_pose.h"

#include "contact/query/point/closest_point.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "contact/shape/mesh/mesh_topology.h"

namespace haptic {

RigidPoseJudge::RigidPoseJudge(const MeshShape& object, const MeshShape& tool)
    : object_(object),
      tool_(tool),
      object_points_(points_of_shells(object.mesh)),
      tool_points_(points_of_shells(tool.mesh)) {}

bool RigidPoseJudge::is_entered(const Pose& X_OT) const {
  return triangle_pairs(object_, tool_, X_OT, {}) > 0 || holds(object_, tool_points_, X_OT) ||
         holds(tool_, object_points_, inverse(X_OT));
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/body/cluster_contact.h"

#include "contact/detect/body/contact_reach.h"

namespace haptic {

Contact contact_of(const PushCluster& cluster_O, uint32_t object, const Pose& X_WO,
                   const Pose& X_WT) {
  HAPTIC_ASSERT(object < kMaxObjects);
  Contact c{};
  c.tool_point_T = inverse(X_WT) * (X_WO * cluster_O.point_O);
  c.object_point_O = cluster_O.point_O + cluster_O.depth * cluster_O.normal_O;
  c.normal_O = c.shading_normal_O = cluster_O.normal_O;
  c.object = object;
  c.stiffness = cluster_O.stiffness;
  return c;
}

void MeshReach::operator()(uint32_t object, const PushCluster& cluster, Contact& contact) const {
  const PlanePatch reach =
      contact_reach(meshes.objects[object], meshes.tool, question.X_OT(object),
                    contact.object_point_O, cluster.point_O, contact.normal_O, search);
  contact.extent = std::max(reach.extent, least_extent);
  contact.curvature = reach.curvature;
}

}  // namespace haptic

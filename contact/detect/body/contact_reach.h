// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/query/triangle/plane_patch.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/math/pose.h"

namespace haptic {

/// One of the two surfaces of a contact, in the frame of its mesh.
struct ContactSide {
  const TriangleMesh& mesh;
  uint32_t triangle = 0;  // that the point lies on
  Feature feature;        // and its part
  Vec3 point, normal;     // of this surface, outward
};

/// How far, and how bent, the surfaces stay in touch while the tool slides along the plane of a
/// contact. Either surface carries the plane as far as it follows it, and two edges that cross do
/// as far as both go on: extent is the largest of these, within [kMinExtent, kMaxExtent].
/// curvature is that of two surfaces rolling on each other, 1/(1/κ_A + 1/κ_B): 0 where one of them
/// is flat, that of the other where one is a corner. Edges have none: along them nothing bends.
PlanePatch contact_reach(const ContactSide& object, const ContactSide& tool, const Pose& X_OT);

/// The same where only the places are known: at the points of both surfaces that are nearest to
/// them. A surface farther than `search` [m] says nothing: extent 0 if both are.
PlanePatch contact_reach(const MeshShape& object, const MeshShape& tool, const Pose& X_OT,
                         const Vec3& object_point_O, const Vec3& tool_point_O, const Vec3& normal_O,
                         double search);

}  // namespace haptic

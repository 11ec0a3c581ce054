// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/math/pose.h"

namespace haptic {

/// True if the surfaces of two meshes intersect, with the tool at X_OT in the object: tests all
/// triangles whose boxes overlap by CGAL's exact predicates on the tool's corners as rounded in O.
/// Shares no code with the collision queries of contact.
bool surfaces_meet_by_cgal(const TriangleMesh& object, const TriangleMesh& tool, const Pose& X_OT);

}  // namespace haptic

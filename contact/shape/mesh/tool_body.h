// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/config/config.h"

namespace haptic {

/// The tool as a rigid body, with the mass, inertia or density that its config gives. What is not
/// given is that of a body filled evenly; a mesh that is not closed has no inside and stands for
/// its bounding box. The ball is about the centre of mass. Products of inertia are left out: the
/// moments are about the axes of T.
ToolBody tool_body(const TriangleMesh& mesh, const ToolConfig& config);

}  // namespace haptic

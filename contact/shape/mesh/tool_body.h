// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/triangle_mesh.h"
#include "proto/config/config.h"

namespace haptic {

/// The tool as a rigid body, with the mass, inertia or density of its config. Missing values are
/// those of a body of uniform density; a mesh that is not closed has no inside, and its bounding
/// box is used. The bounding ball is about the centre of mass. Products of inertia are neglected:
/// the moments are about the axes of T.
ToolBody tool_body(const TriangleMesh& mesh, const ToolConfig& config);

}  // namespace haptic

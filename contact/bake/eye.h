// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/mesh_topology.h"

namespace haptic {

/// A lighter copy of the mesh for the eye: quadric decimation (Garland & Heckbert 1997) to at most
/// `max_triangles`, its vertex normals smooth. Small meshes are copied. Start-up only.
MeshData build_eye_mesh(const TriangleMesh& mesh, size_t max_triangles);

}  // namespace haptic

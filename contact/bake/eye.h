// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/mesh/mesh_topology.h"

namespace haptic {

/// A lighter copy of the mesh for display: quadric decimation (Garland & Heckbert 1997) to at most
/// `max_triangles`, with smooth vertex normals. Small meshes are copied. At start-up only.
MeshData build_eye_mesh(const TriangleMesh& mesh, size_t max_triangles);

}  // namespace haptic

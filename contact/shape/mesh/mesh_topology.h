// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Edges, valences, unit normals, angle-weighted pseudo-normals (of an edge: mean of its faces; of
/// a vertex: Σ αᵢ nᵢ over its corners; Bærentzen & Aanæs 2005) and bounds of an indexed mesh; at
/// start-up only. An edge joins one face that traverses it forwards and one that traverses it
/// backwards; a side without partner is a border, and `closed` means that there is none. Works on
/// any soup: a zero-area face has a zero normal, as has an unused vertex. Indices must be in range.
MeshData build_mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles);

/// A vertex of each shell, that is of each set of triangles connected by edges; at start-up only.
std::vector<Vec3> points_of_shells(const TriangleMesh& mesh);

}  // namespace haptic

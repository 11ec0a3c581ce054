// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Relative to the longest side of the mesh: by how much a piece may fail to be convex, which is
/// what a mesh of floats loses to rounding, and less than half of what its users are promised.
inline constexpr double kPieceTolerance = 4e-7;

/// A partition of the triangles of a mesh into convex pieces.
struct SurfacePieces {
  std::vector<std::vector<uint32_t>> triangles;  // of each piece, in the order in which it grew
  std::vector<uint32_t> piece_of;                // of each triangle
};

/// Surface convex decomposition (Ehmann & Lin 2001). A piece begins with the triangle of the lowest
/// index that has none, and grows over the sides of its triangles, breadth first and flat parts
/// before others. A triangle joins if, each up to kPieceTolerance,
/// - it keeps the piece a disc, or closes it,
/// - every vertex of the piece then lies behind the plane of each of its triangles,
/// - nothing else of the surface enters the hull of the piece: the virtual faces of the hull, which
///   are no part of the surface, then cut nothing, and the hull of a piece of a closed mesh is
///   solid,
/// - no corner of a flat part on a border of the mesh turns inwards: the hull would cover the
/// notch. The mesh has no triangle without an area. At start-up only.
SurfacePieces decompose_surface(const TriangleMesh& mesh);

}  // namespace haptic

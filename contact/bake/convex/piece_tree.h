// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/shape/convex/piece_tree.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Convex pieces of a surface (decompose_surface) and their hierarchy: hulls, merged pairwise until
/// there is one, a level each time their number has halved. Every hull contains those below it. The
/// same mesh has the same tree on every machine. No triangles: no pieces. At start-up only.
PieceTreeData build_piece_tree(const TriangleMesh& mesh);

}  // namespace haptic

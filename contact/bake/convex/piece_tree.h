// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "contact/shape/convex/piece_tree.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// Called with the share of the work that is done, from 0 to 1.
using PieceProgress = std::function<void(double share)>;

/// Convex pieces of a surface (decompose_surface), their contact levels of detail, each simplified
/// (PieceSurgery) until the pieces have halved, and above the coarsest level their hulls, merged
/// pairwise until there is one (Otaduy & Lin 2003). The bounds of every node are those of the
/// original surface and of its leaves' hulls, measured, not added up. A level is kept if it has at
/// most 0.6 of the pieces of the one before. The same mesh has the same tree on every machine. No
/// triangles: no pieces. At start-up only.
PieceTreeData build_piece_tree(const TriangleMesh& mesh, const PieceProgress& progress = {});

}  // namespace haptic

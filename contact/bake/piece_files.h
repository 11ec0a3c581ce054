// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "contact/shape/convex/piece_tree.h"

namespace haptic {

/// The pieces that stand for the whole surface at a level of detail, in the order of the tree; at
/// any level beyond the last that is its root.
std::vector<uint32_t> pieces_at(const PieceTree& tree, uint32_t level);

/// What a level of detail comes to; lengths are the greatest of its pieces [m].
struct PieceLevel {
  size_t pieces = 0, triangles = 0;  // of all faces of their hulls, virtual ones too
  size_t faces = 0, virtual_faces = 0;
  double deviation = 0, hull_distance = 0;           // s and h of Piece
  double least_resolution = 0, most_resolution = 0;  // r of Piece [1/m]
};

/// All levels, the original surface first.
std::vector<PieceLevel> levels_of(const PieceTree& tree);

/// Bytes that the arrays of the tree take.
size_t bytes_of(const PieceTree& tree);

/// The pieces of a level as a binary PLY file [m]: the polygons of each hull, virtual ones too,
/// with vertices of its own, in one colour a piece, at its vertices and at its faces. Each face
/// also says which piece it is of and whether it is virtual. Every program that knows PLY can read
/// it; unknown properties are passed over.
std::string pieces_as_ply(const PieceTree& tree, uint32_t level);

}  // namespace haptic

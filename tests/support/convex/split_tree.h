// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/convex/piece_tree.h"
#include "contact/shape/mesh/primitives.h"

namespace haptic::test {

inline constexpr double kPromised = 1e-6;  // how convex a piece is, of the size of the mesh

/// A PieceTree that owns its arrays.
struct SplitTree {
  std::vector<Piece> pieces;
  std::vector<Vec3> vertices;
  std::vector<HullEdge> edges;
  std::vector<HullFace> faces;
  std::vector<uint32_t> edge_from, leaf_of, level_pieces;

  PieceTree view() const {
    return {pieces, vertices, edges, faces, edge_from, leaf_of, level_pieces};
  }
};

/// A tree made without the baker: at most `most_in_leaf` triangles are a leaf, with their convex
/// hull, whose faces that no triangle lies in are virtual; a single triangle is flat with a virtual
/// back. Above, the triangles are split at the median along the longest side of their box. Each
/// depth of the tree counts as a level of detail, with the deepest corner below the hull as its
/// deviation. Hulls contain what is below them, so hull_distance is 0.
SplitTree split_tree(const Soup& soup, size_t most_in_leaf = 1);

}  // namespace haptic::test

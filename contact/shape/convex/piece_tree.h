// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "contact/shape/convex/hull.h"

namespace haptic {

/// A node of a PieceTree: a convex piece of the surface at one level of detail, or, above the
/// coarsest level, the hull of several.
struct Piece {
  // its hull, in the arrays of the tree
  uint32_t first_vertex, n_vertices;
  uint32_t first_edge, n_edges;
  uint32_t first_face, n_faces;
  uint32_t parent;       // kNoPiece: the root
  uint32_t first_child;  // children are consecutive, and after their parent
  uint32_t n_children;   // 0: a piece of the original surface
  uint32_t level;        // of detail, above those of its children; 0: the original surface
  Vec3 centre;           // of a ball that contains the hull
  double radius;         // of that ball [m]
  double deviation;      // s: of a point of the original surface to its own, and of one of its real
                         // faces to the original surface, at most [m]
  double overhang;  // e: of a point of its real faces outside the original surface, at most [m]
  double hull_distance;  // h: of a point of its leaves' hulls to its own hull, at most [m]
  double resolution;     // r: 1 / mean edge length of its surface; of the hull of several pieces
                         // 1 / √area [1/m]
  double area;           // of the original surface that it stands for [m²]
};

inline constexpr uint32_t kNoPiece = 0xffffffff;

/// Contact levels of detail of one mesh, and at the same time its bounding-volume hierarchy
/// (Otaduy & Lin 2003). The root is piece 0. Hulls are viewed in a view.
template <template <class> class Array>
struct PieceTreeOf {
  Array<Piece> pieces;
  Array<Vec3> vertices;
  Array<HullEdge> edges;         // indices are those within the piece's own hull
  Array<HullFace> faces;         // the same
  Array<uint32_t> edge_from;     // parallel to vertices
  Array<uint32_t> leaf_of;       // of each triangle of the mesh: its leaf piece
  Array<uint32_t> level_pieces;  // number of pieces of each level, the original first

  PieceTreeOf<ArrayView> view() const {
    return {pieces, vertices, edges, faces, edge_from, leaf_of, level_pieces};
  }

  Hull hull(const Piece& piece) const {
    return {vertices.subspan(piece.first_vertex, piece.n_vertices),
            edges.subspan(piece.first_edge, piece.n_edges),
            faces.subspan(piece.first_face, piece.n_faces),
            edge_from.subspan(piece.first_vertex, piece.n_vertices)};
  }
};

using PieceTree = PieceTreeOf<ArrayView>;
using PieceTreeData = PieceTreeOf<ArrayData>;

}  // namespace haptic

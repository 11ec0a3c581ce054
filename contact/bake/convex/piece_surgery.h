// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "contact/bake/convex/surface_pieces.h"

namespace haptic {

/// A convex piece of a simplified surface.
struct SimplePiece {
  std::vector<uint32_t> members;             // pieces of the level before that it stands for
  std::vector<std::array<Vec3, 3>> corners;  // of its triangles
  std::vector<uint32_t> triangles;           // of the original mesh, which these were; parallel
  bool has_moved = false;                    // its triangles are not those of the level before
};

/// Simplifies a surface that consists of convex pieces, and keeps them convex (Otaduy & Lin 2003).
///
/// Edges collapse in the order of what they cost: the root mean square distance of the new vertex
/// to the planes that it stands for, plus a fifth of the length, so that the finest resolution goes
/// first. The vertex is placed where the quadric of its planes and the distance to the middle of
/// its neighbours are least, a filter that leaves out detail of the size of the edge. Where a piece
/// would not stay convex the place is moved into the half-spaces that keep it so, or else an end of
/// the edge is tried; where that fails too, or the vertex
/// would lie farther off its planes than 3 % of the mesh's size, or a triangle would turn over, a
/// piece would be pinched or the surface would cease to be a manifold, the edge stays. Borders of
/// an open mesh stay. A piece that has lost its last triangle becomes a part of the neighbour which
/// looks most like it. After each collapse, neighbouring pieces are merged if together they are a
/// convex disc, or closed, and nothing else of the original surface lies in their hull deeper than
/// a quarter of an edge.
///
/// What is not checked: that triangles far from each other do not come to intersect. At start-up
/// only.
class PieceSurgery {
 public:
  PieceSurgery(const TriangleMesh& mesh, const SurfacePieces& pieces);
  ~PieceSurgery();
  PieceSurgery(const PieceSurgery&) = delete;

  size_t n_pieces() const;

  /// Goes on until at most `target` pieces remain. False: no edge can collapse any more.
  bool simplify(size_t target);

  /// The pieces, in the order of their lowest members. They are the level before from now on, with
  /// these places as their numbers.
  std::vector<SimplePiece> take_level();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace haptic

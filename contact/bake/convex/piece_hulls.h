// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact/shape/convex/piece_tree.h"
#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// A node of a hierarchy of pieces while it is made.
struct BuiltPiece {
  HullData hull;
  Piece facts{};                    // all but its places in the arrays of the tree
  std::vector<uint32_t> children;   // numbers of other nodes
  std::vector<uint32_t> triangles;  // of the original mesh
};

/// The hull of points of a mesh. Points that CGAL takes for a line are given a width of `width`
/// [m].
HullData hull_with_width(std::span<const Vec3> points, double width);

/// Says which faces of the hull are real: those in which one of the triangles lies, to `tolerance`
/// [m]. All others are virtual. `numbers`, parallel: what the triangles are called in the faces.
void label_faces(HullData& hull, std::span<const std::array<Vec3, 3>> triangles,
                 std::span<const uint32_t> numbers, double tolerance);

/// An upper bound of how far points of a triangle with this normal lie off the surface of the
/// hull, inside or outside [m]. `start`: any vertex of the hull, near the farthest along the normal
/// if possible; afterwards that one.
double off_hull(const Hull& hull, const std::array<Vec3, 3>& triangle, const Vec3& normal,
                uint32_t& start);

/// Distance from a point to the hull as a solid; 0 inside [m].
double distance_to_hull(const Hull& hull, const Vec3& p);

/// A ball around points: the centre of their box, moved towards the farthest (Bădoiu & Clarkson
/// 2003).
void bound_by_ball(Piece& piece, std::span<const Vec3> points);

/// The arrays of the tree: children after their parents and consecutive. Level 0 and the counts of
/// the others are in `level_pieces`.
PieceTreeData pack_pieces(const std::vector<BuiltPiece>& built, uint32_t root, size_t n_triangles,
                          std::vector<uint32_t> level_pieces);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/baked/pieces.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr size_t kTreeArrays = 7;     // those of for_each_tree_array
constexpr double kUnit = 1e-9;        // of the square of a unit normal
constexpr double kFarthest = 1e6;     // of any point [m]: farther than anything in a scene
constexpr double kMostOfBound = 1e9;  // of a length or its inverse, in metres

/// Calls f for each array, in the order of the file.
template <class Tree, class F>
void for_each_tree_array(Tree& tree, F&& f) {
  f(tree.pieces), f(tree.vertices), f(tree.edges), f(tree.faces);
  f(tree.edge_from), f(tree.leaf_of), f(tree.level_pieces);
}

bool is_within(uint32_t first, uint32_t n, size_t size) {
  return first <= size && n <= size - first;
}

bool is_point(const Vec3& p) {
  return std::fabs(p.x) <= kFarthest && std::fabs(p.y) <= kFarthest && std::fabs(p.z) <= kFarthest;
}

bool is_bound(double x) {
  return x >= 0 && x <= kMostOfBound;
}

void check_facts(const PieceTree& tree, const Piece& piece) {
  require_baked(is_within(piece.first_vertex, piece.n_vertices, tree.vertices.size()) &&
                    is_within(piece.first_vertex, piece.n_vertices, tree.edge_from.size()) &&
                    is_within(piece.first_edge, piece.n_edges, tree.edges.size()) &&
                    is_within(piece.first_face, piece.n_faces, tree.faces.size()),
                "a piece whose hull is out of range");
  require_baked(is_point(piece.centre) && is_bound(piece.radius) && is_bound(piece.deviation) &&
                    is_bound(piece.hull_distance) && is_bound(piece.overhang) &&
                    is_bound(piece.resolution) && is_bound(piece.area),
                "a piece with impossible numbers");
}

void check_hull(const PieceTree& tree, const Piece& piece) {
  const Hull hull = tree.hull(piece);
  require_baked(hull_links_defect(hull) == nullptr, "a hull that is no polyhedron");
  require_baked(std::all_of(hull.vertices.begin(), hull.vertices.end(), is_point),
                "a vertex that is nowhere");
  for (const HullFace& face : hull.faces) {
    require_baked(std::fabs(norm_squared(face.normal) - 1) < kUnit &&
                      std::fabs(face.offset) <= 2 * kFarthest &&
                      (face.triangle == kNoTriangle || face.triangle < tree.leaf_of.size()),
                  "a broken face");
  }
}

/// Children begin where those of the pieces before them end: each piece but the root has one
/// parent, and comes after it.
void check_piece_tree(const PieceTree& tree) {
  size_t next = 1;
  for (uint32_t i = 0; i < tree.pieces.size(); ++i) {
    const Piece& piece = tree.pieces[i];
    if (i == 0) require_baked(piece.parent == kNoPiece, "a root with a parent");
    if (piece.n_children == 0) continue;
    require_baked(piece.first_child == next && piece.first_child > i &&
                      is_within(piece.first_child, piece.n_children, tree.pieces.size()),
                  "children out of range");
    for (const Piece& child : tree.pieces.subspan(piece.first_child, piece.n_children)) {
      require_baked(child.parent == i && child.level < piece.level, "a child of another parent");
    }
    next += piece.n_children;
  }
  require_baked(next == tree.pieces.size(), "a piece without a parent");
}

void check_pieces(const PieceTree& tree) {
  if (tree.pieces.empty()) {
    return require_baked(tree.leaf_of.empty(), "triangles without pieces");
  }
  require_baked(!tree.level_pieces.empty(), "pieces without levels");
  check_piece_tree(tree);
  for (const Piece& piece : tree.pieces) {
    check_facts(tree, piece);
    check_hull(tree, piece);
  }
  for (const uint32_t leaf : tree.leaf_of) {
    require_baked(leaf < tree.pieces.size() && tree.pieces[leaf].n_children == 0,
                  "a triangle without a piece");
  }
}

}  // namespace

std::vector<std::byte> write_pieces(const PieceTree& tree, uint64_t key) {
  std::vector<std::span<const std::byte>> arrays;
  for_each_tree_array(tree, [&](const auto& array) { arrays.push_back(std::as_bytes(array)); });
  return write_block(BakedKind::kPieces, key, arrays);
}

PieceTree view_pieces(std::span<const std::byte> bytes, uint64_t key, const RunBoth& run_both) {
  const BakedBlock block = view_block(bytes, BakedKind::kPieces, key, kTreeArrays);
  PieceTree tree;
  size_t i = 0;
  for_each_tree_array(
      tree, [&]<class T>(std::span<const T>& array) { array = view_array<T>(block.arrays[i++]); });
  run_both([&] { check_half(block, 0); },
           [&] {
             check_half(block, 1);
             check_pieces(tree);
           });
  return tree;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/piece_files.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <numeric>
#include <set>

#include "contact/bake/convex/hull_of_points.h"
#include "contact/bake/eye_files.h"
#include "contact/bake/soup/read.h"
#include "contact/shape/mesh/primitives.h"
#include "proto/ipc/eye_file.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/mesh_files.h"

using namespace haptic;
using haptic::test::kPlenty;

namespace {

/// A unit box with its middle at x, and what a hull of two of them is.
std::vector<Vec3> corners_at(double x) {
  std::vector<Vec3> corners = make_box({1, 1, 1}).vertices;
  for (Vec3& v : corners) v.x += x;
  return corners;
}

/// Adds a piece with the hull of points; its first face is virtual.
void add_piece(PieceTreeData& tree, const std::vector<Vec3>& points, Piece facts) {
  HullData hull = hull_of_points(points).hull;
  hull.faces.front().is_virtual = 1;
  facts.first_vertex = static_cast<uint32_t>(tree.vertices.size());
  facts.n_vertices = static_cast<uint32_t>(hull.vertices.size());
  facts.first_edge = static_cast<uint32_t>(tree.edges.size());
  facts.n_edges = static_cast<uint32_t>(hull.edges.size());
  facts.first_face = static_cast<uint32_t>(tree.faces.size());
  facts.n_faces = static_cast<uint32_t>(hull.faces.size());
  tree.pieces.push_back(facts);
  tree.vertices.insert(tree.vertices.end(), hull.vertices.begin(), hull.vertices.end());
  tree.edges.insert(tree.edges.end(), hull.edges.begin(), hull.edges.end());
  tree.faces.insert(tree.faces.end(), hull.faces.begin(), hull.faces.end());
  tree.edge_from.insert(tree.edge_from.end(), hull.edge_from.begin(), hull.edge_from.end());
}

/// Three boxes in a row, 0, 2 and 4; the first two are one piece at level 1, all three at level 2.
/// Piece 2, the third box, stands for itself at two levels.
PieceTreeData three_boxes() {
  std::vector<Vec3> pair = corners_at(0), all;
  for (const Vec3& v : corners_at(2)) pair.push_back(v);
  all = pair;
  for (const Vec3& v : corners_at(4)) all.push_back(v);
  PieceTreeData tree;
  const auto facts = [](uint32_t parent, uint32_t level, double deviation) {
    Piece piece{};
    piece.parent = parent;
    piece.level = level;
    piece.deviation = deviation;
    piece.hull_distance = 2 * deviation;
    piece.resolution = 1.0 / (1 + level);
    return piece;
  };
  add_piece(tree, all, facts(kNoPiece, 2, 0.5));
  add_piece(tree, pair, facts(0, 1, 0.25));
  add_piece(tree, corners_at(4), facts(0, 0, 0));
  add_piece(tree, corners_at(0), facts(1, 0, 0));
  add_piece(tree, corners_at(2), facts(1, 0, 0.1));
  tree.level_pieces = {3, 2, 1};
  return tree;
}

/// Sum of the coordinates of the points that each polygon uses.
Vec3 middle_of(const std::vector<size_t>& polygon, const std::vector<Vec3>& points) {
  Vec3 sum;
  for (const size_t i : polygon) sum += points[i];
  return 1.0 / static_cast<double>(polygon.size()) * sum;
}

}  // namespace

TEST_CASE("pieces of a level: a cut of the tree, and a piece may stand at several levels") {
  const PieceTreeData tree = three_boxes();
  CHECK(pieces_at(tree.view(), 0) == std::vector<uint32_t>{2, 3, 4});
  CHECK(pieces_at(tree.view(), 1) == std::vector<uint32_t>{1, 2});
  CHECK(pieces_at(tree.view(), 2) == std::vector<uint32_t>{0});
  CHECK(pieces_at(tree.view(), 7) == std::vector<uint32_t>{0});
  CHECK(pieces_at(PieceTree{}, 0).empty());
}

TEST_CASE("levels of detail: counts and the greatest of their pieces") {
  const std::vector<PieceLevel> levels = levels_of(three_boxes().view());
  REQUIRE(levels.size() == 3);
  for (size_t i = 0; i < 3; ++i) {
    CAPTURE(i);
    // each hull is a box: six faces, of which the first is virtual, and twelve triangles
    CHECK(levels[i].pieces == 3 - i);
    CHECK(levels[i].faces == 6 * levels[i].pieces);
    CHECK(levels[i].triangles == 12 * levels[i].pieces);
    CHECK(levels[i].virtual_faces == levels[i].pieces);
  }
  CHECK(levels[0].deviation == 0.1);
  CHECK(levels[0].hull_distance == 0.2);
  CHECK(levels[1].deviation == 0.25);
  CHECK(levels[1].least_resolution == 0.5);
  CHECK(levels[1].most_resolution == 1);
}

TEST_CASE("PLY of pieces: other programs read the same polygons, one colour a piece") {
  const std::string ply = pieces_as_ply(three_boxes().view(), 0);
  const test::CgalPly read = test::cgal_read_ply(ply);
  REQUIRE(read.is_read);
  REQUIRE(read.points.size() == 24);
  REQUIRE(read.polygons.size() == 18);
  REQUIRE(read.point_colours.size() == 24);
  REQUIRE(read.polygon_colours.size() == 18);
  // the boxes at 4, 0 and 2: of each six faces half a side from its middle, and one colour
  std::set<std::array<uint8_t, 3>> colours;
  for (size_t i = 0; i < 18; ++i) {
    CAPTURE(i);
    CHECK(read.polygons[i].size() == 4);
    const double x = std::array{4.0, 0.0, 2.0}[i / 6];
    CHECK(norm(middle_of(read.polygons[i], read.points) - Vec3{x, 0, 0}) == Approx(0.5));
    CHECK(read.polygon_colours[i] == read.polygon_colours[6 * (i / 6)]);
    for (const size_t corner : read.polygons[i]) {
      CHECK(read.point_colours[corner] == read.polygon_colours[i]);
    }
    colours.insert(read.polygon_colours[i]);
  }
  CHECK(colours.size() == 3);
  // our own reader, which the baker uses
  const PolygonSoup soup = read_mesh(ply, "pieces.ply", kPlenty);
  CHECK(soup.points.size() == 24);
  CHECK(soup.polygons.size() == 18);
  CHECK(pieces_as_ply(three_boxes().view(), 2).size() < ply.size());
}

TEST_CASE("the eye file of pieces: no two pieces share a vertex") {
  ShapeConfig shape{};
  assign(shape.name, "boxes");
  const std::vector<std::byte> bytes = make_piece_eye(3, shape, three_boxes().view());
  const EyeFile eye = view_eye(bytes);
  CHECK(eye.object == 3);
  CHECK(eye.name == "boxes");
  REQUIRE(eye.vertices.size() == 24);
  REQUIRE(eye.triangles.size() == 36);
  // eight vertices and twelve triangles each, in turn; together the triangles are the box's surface
  double area = 0;
  for (size_t i = 0; i < 36; ++i) {
    const auto corner = [&](size_t k) {
      const EyePoint& p = eye.vertices[eye.triangles[i][k]];
      return Vec3{p[0], p[1], p[2]};
    };
    for (size_t k = 0; k < 3; ++k) CHECK(eye.triangles[i][k] / 8 == i / 12);
    const Vec3 normal = cross(corner(1) - corner(0), corner(2) - corner(0));
    const double x = std::array{4.0, 0.0, 2.0}[i / 12];
    CHECK(dot(normal, corner(0) - Vec3{x, 0, 0}) > 0);
    area += 0.5 * norm(normal);
  }
  CHECK(area == Approx(18));
}

TEST_CASE("the eye file of many pieces is that of a coarser level") {
  // 4096 boxes of 12 triangles under one: more than are drawn
  PieceTreeData tree;
  Piece root{};
  root.parent = kNoPiece;
  root.level = 1;
  add_piece(tree, corners_at(0), root);
  for (int i = 0; i < 4096; ++i) add_piece(tree, corners_at(i), Piece{});
  tree.level_pieces = {4096, 1};
  CHECK(view_eye(make_piece_eye(0, {}, tree.view())).triangles.size() == 12);
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>

#include "contact/bake/piece_files.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/mesh/primitives.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

struct Made {
  MeshData mesh;
  PieceTreeData data;
  PieceTree tree;
  double size;
};

Made make(const Soup& soup) {
  Made made;
  made.mesh = build_mesh(soup.vertices, soup.triangles);
  made.data = build_piece_tree(made.mesh.view());
  made.tree = made.data.view();
  const Vec3 side = made.mesh.upper - made.mesh.lower;
  made.size = std::max({side.x, side.y, side.z});
  return made;
}

/// By how much a point lies outside of the hull, along the normal of one of its faces.
double most_outside(const Hull& hull, const Vec3& p) {
  double most = 0;
  for (const HullFace& face : hull.faces) {
    most = std::max(most, dot(face.normal, p) - face.offset);
  }
  return most;
}

void check_links(const PieceTree& tree) {
  REQUIRE(!tree.pieces.empty());
  CHECK(tree.pieces[0].parent == kNoPiece);
  std::vector<int> times(tree.pieces.size(), 0);
  for (uint32_t i = 0; i < tree.pieces.size(); ++i) {
    const Piece& piece = tree.pieces[i];
    // a piece that has only been simplified has one
    if (piece.level >= tree.level_pieces.size()) CHECK(piece.n_children != 1);
    for (uint32_t c = 0; c < piece.n_children; ++c) {
      const uint32_t child = piece.first_child + c;
      REQUIRE(child > i);
      REQUIRE(child < tree.pieces.size());
      CHECK(tree.pieces[child].parent == i);
      CHECK(tree.pieces[child].level < piece.level);
      ++times[child];
    }
  }
  CHECK(std::all_of(times.begin() + 1, times.end(), [](int n) { return n == 1; }));
}

void check_bounds(const Made& made) {
  const PieceTree& tree = made.tree;
  double outside = 0, off_plane = 0;
  for (const Piece& piece : tree.pieces) {
    const Hull hull = tree.hull(piece);
    const char* defect = hull_defect(hull, 1e-6 * made.size);
    CHECK((defect == nullptr ? "" : std::string(defect)) == "");
    CHECK(piece.resolution > 0);
    for (const Vec3& v : hull.vertices) CHECK(norm(v - piece.centre) <= piece.radius);
    for (const HullFace& face : hull.faces) {
      CHECK((face.is_virtual == 1) == (face.triangle == kNoTriangle));
      // of a simplified piece it is the triangle that its own has been made of
      if (face.triangle == kNoTriangle || piece.n_children != 0) continue;
      const Triangle& t = made.mesh.triangles[face.triangle];
      for (const uint32_t v : t) {
        off_plane =
            std::max(off_plane, std::fabs(dot(face.normal, made.mesh.vertices[v]) - face.offset));
      }
    }
  }
  CHECK(off_plane <= 1e-6 * made.size);
  // of every triangle up to the root
  for (uint32_t t = 0; t < made.mesh.triangles.size(); ++t) {
    for (uint32_t i = tree.leaf_of[t]; i != kNoPiece; i = tree.pieces[i].parent) {
      const Piece& piece = tree.pieces[i];
      for (const uint32_t v : made.mesh.triangles[t]) {
        outside =
            std::max(outside, most_outside(tree.hull(piece), made.mesh.vertices[v]) -
                                  piece.hull_distance - tree.pieces[tree.leaf_of[t]].deviation);
      }
    }
  }
  CHECK(outside <= 1e-12);
}

/// A point of the surface, and its triangle.
std::pair<size_t, Vec3> random_point(const Made& made, Random& random) {
  const size_t t = random.index(made.mesh.triangles.size());
  const auto& [a, b, c] = made.mesh.triangles[t];
  const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
  const Vec3& origin = made.mesh.vertices[a];
  return {t, origin + u * (made.mesh.vertices[b] - origin) + v * (made.mesh.vertices[c] - origin)};
}

/// Points of the surface against the hulls above them, up to the root: CGAL's exact quadratic
/// program says how far outside they are.
void check_containment(const Made& made) {
  Random random(11);
  double beyond = 0;
  for (int n = 0; n < 20; ++n) {
    const auto [t, p] = random_point(made, random);
    const double of_leaf = made.tree.pieces[made.tree.leaf_of[t]].deviation;
    for (uint32_t i = made.tree.leaf_of[t]; i != kNoPiece; i = made.tree.pieces[i].parent) {
      const Hull hull = made.tree.hull(made.tree.pieces[i]);
      const double outside =
          cgal_polytope_distance({p}, {hull.vertices.begin(), hull.vertices.end()});
      beyond = std::max(beyond, outside - made.tree.pieces[i].hull_distance - of_leaf);
    }
  }
  CHECK(beyond <= 1e-12);
}

/// Points of the surface against the level's own surface: none is farther from the hulls of all
/// pieces of a level than the deviation of the piece that stands for it.
void check_deviations(const Made& made) {
  Random random(12);
  double beyond = 0;
  for (uint32_t level = 0; level < made.tree.level_pieces.size(); ++level) {
    const std::vector<uint32_t> pieces = pieces_at(made.tree, level);
    for (int n = 0; n < 15; ++n) {
      const auto [t, p] = random_point(made, random);
      uint32_t own = made.tree.leaf_of[t];
      while (std::find(pieces.begin(), pieces.end(), own) == pieces.end()) {
        own = made.tree.pieces[own].parent;
      }
      double nearest = 1;
      for (const uint32_t i : pieces) {
        const Hull hull = made.tree.hull(made.tree.pieces[i]);
        double depth = 1;
        for (const HullFace& face : hull.faces) {
          depth = std::min(depth, face.offset - dot(face.normal, p));
        }
        // outside, the depth below the best plane is a lower bound of the distance
        nearest = std::min(nearest, std::fabs(depth));
      }
      beyond = std::max(beyond, nearest - made.tree.pieces[own].deviation);
    }
  }
  CHECK(beyond <= 1e-12);
}

void check_counts(const Made& made) {
  const PieceTree& tree = made.tree;
  REQUIRE(!tree.level_pieces.empty());
  const auto leaves = std::count_if(tree.pieces.begin(), tree.pieces.end(),
                                    [](const Piece& p) { return p.n_children == 0; });
  CHECK(tree.level_pieces[0] == leaves);
  for (size_t i = 0; i + 1 < tree.level_pieces.size(); ++i) {
    const double before = tree.level_pieces[i], after = tree.level_pieces[i + 1];
    CHECK(after <= 0.6 * before);
    // of few pieces several may vanish with one edge
    if (before > 10) CHECK(after >= 0.4 * before);
  }
  for (uint32_t level = 0; level < tree.level_pieces.size(); ++level) {
    CHECK(pieces_at(tree, level).size() == tree.level_pieces[level]);
  }
  // hulls above halve until there is one
  size_t n = tree.level_pieces.back();
  for (uint32_t level = static_cast<uint32_t>(tree.level_pieces.size()); n > 1; ++level) {
    CHECK(pieces_at(tree, level).size() == (n + 1) / 2);
    n = (n + 1) / 2;
  }
  double area = 0, of_leaves = 0;
  for (size_t t = 0; t < made.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = made.mesh.triangles[t];
    const Vec3& p = made.mesh.vertices[a];
    area += 0.5 * norm(cross(made.mesh.vertices[b] - p, made.mesh.vertices[c] - p));
  }
  for (const Piece& piece : tree.pieces) of_leaves += piece.n_children == 0 ? piece.area : 0;
  CHECK(of_leaves == Approx(area).epsilon(1e-9));
  CHECK(tree.pieces[0].area == Approx(area).epsilon(1e-9));
}

void check(const Made& made) {
  check_links(made.tree);
  check_bounds(made);
  check_containment(made);
  check_deviations(made);
  check_counts(made);
}

}  // namespace

TEST_CASE("piece tree: a box is one piece without virtual faces") {
  const Made made = make(make_box({0.02, 0.03, 0.05}));
  check(made);
  CHECK(made.tree.pieces.size() == 1);
  CHECK(made.tree.faces.size() == 6);
  CHECK(made.tree.vertices.size() == 8);
  for (const HullFace& face : made.tree.faces) CHECK(face.is_virtual == 0);
}

TEST_CASE("piece tree: an open sheet is a polygon of two sides, one of them virtual") {
  const Made made = make(make_grid(0.03, 6));
  check(made);
  REQUIRE(made.tree.faces.size() == 2);
  const size_t front = made.tree.faces[0].normal.z > 0 ? 0 : 1;
  CHECK(made.tree.faces[front].is_virtual == 0);
  CHECK(made.tree.faces[front].triangle == 0);
  CHECK(made.tree.faces[1 - front].is_virtual == 1);
}

TEST_CASE("piece tree: an L is two pieces and their common hull") {
  const Made made = make(make_l_shape(0.02, 0.01));
  check(made);
  REQUIRE(made.tree.pieces.size() == 3);
  // the hull of an L has one face that is none of its own, from arm to arm
  const Hull hull = made.tree.hull(made.tree.pieces[0]);
  CHECK(hull.faces.size() == 7);
  CHECK(std::count_if(hull.faces.begin(), hull.faces.end(),
                      [](const HullFace& f) { return f.is_virtual == 1; }) == 1);
  // it lies over the inner corner, which is half of the diagonal of an arm's width away
  CHECK(made.tree.pieces[0].deviation >= 0.01 * std::sqrt(0.5) - 1e-9);
}

TEST_CASE("piece tree: a bumpy ball, a torus, a sheet and machine parts") {
  check(make(make_bumpy_ball(0.02, 2, 0.05, 12)));
  check(make(make_torus(0.03, 0.01, 24, 12)));
  check(make(make_rough_sheet(3, 16, 0.3)));
  check(make(make_gear({.grid = {96, 1}})));
  check(make(make_hole({{.grid = {16, 2}}})));
  check(make(make_bolt({{.grid = {16, 32}}})));
}

TEST_CASE("piece tree: real faces lie off a ball by no more than they say") {
  constexpr double kRadius = 0.02;  // [m]
  constexpr double kShare = 0.02, kWaves = 12;
  constexpr double kFacets = 0.1e-3;  // the mesh lies that far off the ball, at most [m]
  constexpr double kSlope = 1.1;      // along the radius it is farther than along the normal
  const Made made = make(make_bumpy_ball(kRadius, 4, kShare, kWaves));
  REQUIRE(made.tree.level_pieces.size() > 1);
  Random random(21);
  double beyond = 0, outside = 0, most = 0;
  for (uint32_t level = 1; level < made.tree.level_pieces.size(); ++level) {
    for (const uint32_t i : pieces_at(made.tree, level)) {
      const Piece& piece = made.tree.pieces[i];
      const Hull hull = made.tree.hull(piece);
      for (const HullFace& face : hull.faces) {
        if (face.is_virtual != 0) continue;
        // a point of the face, between its corners by random weights
        Vec3 p;
        double sum = 0;
        for (uint32_t k = 0; k < face.n_edges; ++k) {
          const double weight = random.uniform(0.01, 1);
          p += weight * hull.vertices[hull.edges[face.first_edge + k].from];
          sum += weight;
        }
        p = p / sum;
        const Vec3 n = normalized(p);
        const double wave =
            std::sin(kWaves * n.x) * std::sin(kWaves * n.y) * std::sin(kWaves * n.z);
        const double off = (norm(p) - kRadius * (1 + kShare * wave)) / kSlope;
        beyond = std::max(beyond, std::fabs(off) - piece.deviation);
        outside = std::max(outside, off - piece.overhang);
        most = std::max(most, off);
      }
    }
  }
  CAPTURE(most);
  CHECK(most > 3 * kFacets);
  CHECK(beyond < kFacets);
  CHECK(outside < kFacets);
}

TEST_CASE("piece tree: solids apart from each other end in one root") {
  Soup two = make_icosphere(0.01, 1);
  append(two, make_icosphere(0.01, 1), {0.05, 0, 0});
  const Made made = make(two);
  check(made);
  CHECK(made.tree.pieces.size() == 3);
}

TEST_CASE("piece tree: no triangles, no pieces") {
  CHECK(make({}).tree.pieces.empty());
}

TEST_CASE("piece tree: the same mesh has the same tree, wherever the memory lies") {
  // of a body turned about an axis, quadrilaterals lie in a plane to the last bit: by either of
  // their diagonals the hull is the same
  primitive::JointBall ball;
  ball.around = 60;
  const Soup soup = GENERATE_COPY(make_bumpy_ball(0.02, 2, 0.05, 12), make_mesh(Primitive{ball}));
  const Made a = make(soup);
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
  };
  std::mt19937 engine(3);
  std::vector<std::vector<char>> in_the_way;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2000; ++k) in_the_way.emplace_back(16 + engine() % 3000);
    for (int k = 0; k < 1000; ++k) {
      std::swap(in_the_way[engine() % in_the_way.size()], in_the_way.back());
      in_the_way.pop_back();
    }
    const Made b = make(soup);
    CHECK(same(a.data.pieces, b.data.pieces));
    CHECK(same(a.data.vertices, b.data.vertices));
    CHECK(same(a.data.faces, b.data.faces));
  }
}

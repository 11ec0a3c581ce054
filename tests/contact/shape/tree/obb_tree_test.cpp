// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/shape/tree/obb_tree.h"

#include <catch2/catch.hpp>
#include <numbers>
#include <set>

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

// algebra on unit vectors: a few dozen roundings
constexpr double kAlgebraTolerance = 1e-12;
// boxes are kept in floats
constexpr double kFloatTolerance = 1e-6;

/// Checks every guarantee of the header; returns the depth of the deepest leaf.
int check_tree(const MeshShapeData& shape) {
  const ObbTree tree = shape.tree.view();
  const TriangleMesh mesh = shape.mesh.view();
  std::vector<int> seen(mesh.triangles.size(), 0);
  int deepest = 0;
  size_t visited = 0;
  std::vector<std::pair<uint32_t, int>> todo{{0, 0}};
  while (!todo.empty()) {
    const auto [index, depth] = todo.back();
    todo.pop_back();
    ++visited;
    deepest = std::max(deepest, depth);
    const ObbNode& node = tree.nodes[index];
    const Obb box = node.box.unpacked();
    // beyond the range of floats a box excludes nothing
    const bool is_open = std::isinf(box.half.x);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double d = dot(box.R_BO.row[i], box.R_BO.row[j]);
        REQUIRE(std::fabs(d - (i == j && !is_open ? 1 : 0)) < tol(kFloatTolerance));
      }
    }
    // every triangle below must lie in the box, without tolerance
    std::vector<uint32_t> below;
    std::vector<uint32_t> open{index};
    while (!open.empty()) {
      const ObbNode& inner = tree.nodes[open.back()];
      open.pop_back();
      if (inner.count == 0) {
        open.insert(open.end(), {inner.first, inner.first + 1u});
        continue;
      }
      for (uint32_t k = 0; k < inner.count; ++k) below.push_back(tree.order[inner.first + k]);
    }
    bool inside = true;
    for (const uint32_t t : below) {
      for (const uint32_t v : mesh.triangles[t]) {
        const Vec3 q = box.R_BO * (mesh.vertices[v] - box.centre_O);
        inside = inside && std::fabs(q.x) <= box.half.x && std::fabs(q.y) <= box.half.y &&
                 std::fabs(q.z) <= box.half.z;
      }
    }
    REQUIRE(inside);
    if (node.count == 0) {
      REQUIRE(node.first > index);
      todo.push_back({node.first, depth + 1});
      todo.push_back({node.first + 1, depth + 1});
    } else {
      for (uint32_t k = 0; k < node.count; ++k) ++seen[tree.order[node.first + k]];
    }
  }
  REQUIRE(visited == tree.nodes.size());
  REQUIRE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  REQUIRE(deepest <= kMaxTreeDepth);
  return deepest;
}

}  // namespace

TEST_CASE("obb tree: boxes hold their triangles and each triangle is in one leaf") {
  check_tree(build_shape(make_box({1, 2, 3})));
  check_tree(build_shape(make_grid(0.05, 20)));
  CHECK(check_tree(build_shape(make_icosphere(0.05, 4))) < 20);
  check_tree(build_shape(make_degenerate_soup(3, 2000)));
  Soup bunny = load_off("bunny00.off", 0.1);
  if (kSlowdown == 1 && !bunny.triangles.empty()) CHECK(check_tree(build_shape(bunny)) < 32);
}

TEST_CASE("obb tree: identical and degenerate triangles stay within the depth limit") {
  Soup same{{{1, 2, 3}, {2, 2, 3}, {1, 3, 3}}, {}};
  same.triangles.assign(5000, {0, 1, 2});
  check_tree(build_shape(same));

  Soup points{{{1, 2, 3}}, {}};
  points.triangles.assign(5000, {0, 0, 0});
  check_tree(build_shape(points));

  // each mean split peels off one triangle: the worst case for depth
  Soup peel;
  for (uint32_t i = 0; i < 400; ++i) {
    const double x = std::pow(2.0, 0.5 * i);
    peel.vertices.insert(peel.vertices.end(), {{x, 0, 0}, {x * 1.1, 0, 0}, {x, x * 0.1, 0}});
    peel.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  CHECK(check_tree(build_shape(peel)) > 20);
}

TEST_CASE("obb tree: an empty mesh has an empty tree and one triangle is a leaf") {
  CHECK(build_shape({}).tree.nodes.empty());
  const MeshShapeData one = build_shape({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  REQUIRE(one.tree.nodes.size() == 1);
  CHECK(one.tree.nodes[0].count == 1);
}

TEST_CASE("obb tree: the root of a turned box-shaped grid is aligned with it") {
  // closed form: the covariance of a rectangle has its sides as eigenvectors
  Random random(5);
  const Pose X = random.pose(0.3);
  Soup grid = make_grid(0.05, 8);
  for (Vec3& v : grid.vertices) v = X * Vec3{2 * v.x, v.y, 0};
  const Obb box = build_shape(grid).tree.nodes[0].box.unpacked();
  CHECK(std::fabs(dot(box.R_BO.row[0], rotate(X.q, {1, 0, 0}))) > 1 - tol(kFloatTolerance));
  CHECK(std::fabs(dot(box.R_BO.row[2], rotate(X.q, {0, 0, 1}))) > 1 - tol(kFloatTolerance));
  CHECK_THAT(box.centre_O, IsNear(X.p, kFloatTolerance));
  CHECK_THAT(box.half, IsNear({0.1, 0.05, 0}, kFloatTolerance));
}

TEST_CASE("mesh topology: Euler, unit normals, closedness and borders") {
  const MeshData sphere = build_mesh(make_icosphere(1, 3).vertices, make_icosphere(1, 3).triangles);
  CHECK(sphere.closed);
  CHECK(sphere.vertices.size() + sphere.triangles.size() == sphere.edge_faces.size() + 2);
  double volume = 0;
  for (size_t f = 0; f < sphere.triangles.size(); ++f) {
    const auto& [a, b, c] = sphere.triangles[f];
    CHECK(std::fabs(norm(sphere.face_normals[f]) - 1) < tol(kAlgebraTolerance));
    volume += dot(sphere.vertices[a], cross(sphere.vertices[b], sphere.vertices[c])) / 6;
    for (uint32_t i = 0; i < 3; ++i) {
      const auto& faces = sphere.edge_faces[sphere.triangle_edges[f][i]];
      CHECK((faces[0] == f || faces[1] == f));
    }
  }
  // inscribed: a little less than the ball, and oriented outwards
  CHECK(volume > 0.98 * 4 / 3 * std::numbers::pi);
  CHECK(volume < 4.0 / 3 * std::numbers::pi);
  for (size_t v = 0; v < sphere.vertices.size(); ++v) {
    CHECK(dot(sphere.vertex_normals[v], sphere.vertices[v]) > 0.999);
    CHECK((sphere.vertex_valence[v] == 5 || sphere.vertex_valence[v] == 6));
  }

  const Soup grid = make_grid(1, 4);
  const MeshData open = build_mesh(grid.vertices, grid.triangles);
  CHECK_FALSE(open.closed);
  const auto borders = std::count_if(open.edge_faces.begin(), open.edge_faces.end(),
                                     [](const auto& f) { return f[1] == kNoFace; });
  CHECK(borders == 16);
  for (const Vec3& n : open.vertex_normals) CHECK_THAT(n, IsNear({0, 0, 1}, kAlgebraTolerance));
}

TEST_CASE("mesh topology: the corner of a cube has the space diagonal as pseudo-normal") {
  // angle weights make it independent of the triangulation of the faces
  const Soup box = make_box({2, 2, 2});
  const MeshData mesh = build_mesh(box.vertices, box.triangles);
  CHECK(mesh.closed);
  for (size_t v = 0; v < 8; ++v) {
    CHECK_THAT(mesh.vertex_normals[v], IsNear(normalized(mesh.vertices[v]), kAlgebraTolerance));
  }
}

TEST_CASE("mesh topology: a flipped face opens the mesh") {
  Soup box = make_box({1, 1, 1});
  std::swap(box.triangles[4][0], box.triangles[4][1]);
  CHECK_FALSE(build_mesh(box.vertices, box.triangles).closed);
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/surface_pieces.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <set>

#include "contact/bake/convex/hull_of_points.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/convex/split_tree.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Whether the triangles are connected over their sides and have as many vertices and edges as a
/// disc (V − E + F = 1), or a closed surface (2).
bool is_disc_or_ball(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles) {
  std::set<uint32_t> vertices, edges;
  std::set<uint32_t> mine(triangles.begin(), triangles.end()), reached{triangles[0]};
  std::vector<uint32_t> waiting{triangles[0]};
  while (!waiting.empty()) {
    const uint32_t t = waiting.back();
    waiting.pop_back();
    for (const uint32_t e : mesh.triangle_edges[t]) {
      for (const uint32_t other : mesh.edge_faces[e]) {
        if (mine.contains(other) && reached.insert(other).second) waiting.push_back(other);
      }
    }
  }
  for (const uint32_t t : triangles) {
    vertices.insert(mesh.triangles[t].begin(), mesh.triangles[t].end());
    edges.insert(mesh.triangle_edges[t].begin(), mesh.triangle_edges[t].end());
  }
  const auto euler = static_cast<long>(vertices.size()) - static_cast<long>(edges.size()) +
                     static_cast<long>(triangles.size());
  return reached.size() == mine.size() && (euler == 1 || euler == 2);
}

/// The most by which a corner of the piece lies above the plane of one of its triangles.
double most_above_piece(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles) {
  std::set<uint32_t> corners;
  for (const uint32_t t : triangles) {
    corners.insert(mesh.triangles[t].begin(), mesh.triangles[t].end());
  }
  double most = 0;
  for (const uint32_t t : triangles) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3& p = mesh.vertices[a];
    const Vec3 n = cross(mesh.vertices[b] - p, mesh.vertices[c] - p);
    for (const uint32_t v : corners) most = std::max(most, dot(n, mesh.vertices[v] - p) / norm(n));
  }
  return most;
}

/// The deepest that any of these points lies in the hull of the piece.
double deepest_in_hull(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles,
                       const std::vector<Vec3>& points) {
  std::vector<Vec3> corners;
  for (const uint32_t t : triangles) {
    for (const uint32_t v : mesh.triangles[t]) corners.push_back(mesh.vertices[v]);
  }
  Vec3 lower = corners[0], upper = corners[0];
  for (const Vec3& p : corners) lower = component_min(lower, p), upper = component_max(upper, p);
  const HullData hull = hull_of_points(corners).hull;
  double deepest = 0;
  for (const Vec3& p : points) {
    if (component_min(p, lower) != lower || component_max(p, upper) != upper) continue;
    double depth = 1;
    for (const HullFace& face : hull.faces) {
      depth = std::min(depth, face.offset - dot(face.normal, p));
    }
    deepest = std::max(deepest, depth);
  }
  return deepest;
}

void check_pieces(const TriangleMesh& mesh, const SurfacePieces& pieces) {
  const Vec3 side = mesh.upper - mesh.lower;
  const double size = std::max({side.x, side.y, side.z});
  Random random(7);
  std::vector<Vec3> points;
  for (int i = 0; i < 5000; ++i) points.push_back(random.on_surface(mesh));
  std::vector<int> times(mesh.triangles.size(), 0);
  size_t not_discs = 0;
  double above = 0, deepest = 0;
  for (uint32_t i = 0; i < pieces.triangles.size(); ++i) {
    for (const uint32_t t : pieces.triangles[i]) {
      ++times[t];
      REQUIRE(pieces.piece_of[t] == i);
    }
    not_discs += is_disc_or_ball(mesh, pieces.triangles[i]) ? 0 : 1;
    above = std::max(above, most_above_piece(mesh, pieces.triangles[i]));
    deepest = std::max(deepest, deepest_in_hull(mesh, pieces.triangles[i], points));
  }
  CHECK(std::all_of(times.begin(), times.end(), [](int n) { return n == 1; }));
  CHECK(not_discs == 0);
  CHECK(above <= kPromised * size);
  // a point of the surface is on the hull of its own piece and in no other: no virtual face cuts it
  CHECK(deepest <= kPromised * size);
}

SurfacePieces pieces_of(const Soup& soup) {
  const MeshData mesh = build_mesh(soup.vertices, soup.triangles);
  SurfacePieces pieces = decompose_surface(mesh.view());
  check_pieces(mesh.view(), pieces);
  return pieces;
}

size_t n_pieces(const Soup& soup) {
  return pieces_of(soup).triangles.size();
}

}  // namespace

TEST_CASE("surface pieces: what is convex is one piece") {
  CHECK(n_pieces(make_box({0.02, 0.03, 0.05})) == 1);
  CHECK(n_pieces(make_icosphere(0.02, 3)) == 1);
  CHECK(n_pieces(make_grid(0.03, 12)) == 1);
  CHECK(n_pieces(make_peg({.grid = {48, 8}})) == 1);
}

TEST_CASE(
    "surface pieces: a box with an edge out of its corner is cut at the concave edges alone") {
  // an L-shaped prism has one concave edge: two convex solids fill it
  CHECK(n_pieces(make_l_shape(0.02, 0.01)) == 2);
}

TEST_CASE(
    "surface pieces: an open dome is one piece from outside and one a triangle or two from in") {
  CHECK(n_pieces(make_height_sheet(0.03, 12,
                                   [](double x, double y) { return -5 * (x * x + y * y); })) == 1);
  const SurfacePieces bowl = pieces_of(
      make_height_sheet(0.03, 12, [](double x, double y) { return 5 * (x * x + y * y); }));
  // the two triangles of a quad are coplanar where z is a sum of functions of x and of y
  CHECK(bowl.triangles.size() == 144);
}

TEST_CASE("surface pieces: a flat part with a notch is cut, though its hull has no volume") {
  // the hull of the whole would lie over the notch, where there is nothing
  const SurfacePieces pieces = pieces_of(make_flat_l(0.02));
  CHECK(pieces.triangles.size() == 2);
}

TEST_CASE("surface pieces: a ring of triangles does not close around what is not part of it") {
  // the convex ring around a dent would have a hull that fills the dent
  const SurfacePieces pieces = pieces_of(make_dented_ball(0.02, 3, 0.5, 2e-3));
  CHECK(pieces.triangles.size() > 2);
}

TEST_CASE("surface pieces: a spiral is locally convex everywhere, and yet is cut") {
  // 1.5 turns of a strip wound outwards: each edge is convex, the whole is not
  const SurfacePieces pieces = pieces_of(make_spiral_strip(0.01, 0.004, 1.5, 60));
  CHECK(pieces.triangles.size() >= 2);
}

TEST_CASE("surface pieces: a virtual face does not reach through a part on the other side") {
  // a cap over a needle that stands beneath it: the hull of the whole cap would contain the tip
  const SurfacePieces pieces = pieces_of(make_cap_over_needle(0.02));
  CHECK(pieces.triangles.size() > 1);
}

TEST_CASE("surface pieces: machine parts, a torus and a bumpy ball") {
  CHECK(n_pieces(make_gear({.grid = {96, 2}})) < 300);
  CHECK(n_pieces(make_hole({{.grid = {32, 4}}})) < 100);
  CHECK(n_pieces(make_bolt({{.grid = {24, 32}}})) > 16);
  CHECK(n_pieces(make_torus(0.03, 0.01, 32, 16)) < 100);
  CHECK(n_pieces(make_bumpy_ball(0.02, 3, 0.05, 12)) > 100);
}

TEST_CASE("surface pieces: a scanned bone") {
  const Soup soup = load_off("femur.off", 0.08);
  if (soup.triangles.empty()) return;
  const size_t n = n_pieces(soup);
  CHECK(n < soup.triangles.size() / 2);
}

TEST_CASE("surface pieces: two solids far apart are not one piece") {
  Soup two = make_box({0.01, 0.01, 0.01});
  const Soup other = make_box({0.01, 0.01, 0.01});
  for (const Vec3& v : other.vertices) two.vertices.push_back(v + Vec3{0.05});
  for (const Triangle& t : other.triangles) two.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  CHECK(n_pieces(two) == 2);
}

TEST_CASE("surface pieces: coordinates rounded to floats do not cut a box") {
  Soup box = make_box({0.021, 0.033, 0.057});
  const Pose X{{0.03, -0.02, 0.01}, from_rotation_vector({0.3, 0.7, -0.4})};
  for (Vec3& v : box.vertices) {
    const std::array<float, 3> rounded = to_floats(X * v);
    v = {rounded[0], rounded[1], rounded[2]};
  }
  CHECK(n_pieces(box) == 1);
}

TEST_CASE("surface pieces: the same mesh has the same pieces") {
  const Soup soup = make_bumpy_ball(0.02, 3, 0.05, 12);
  CHECK(pieces_of(soup).triangles == pieces_of(soup).triangles);
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_surgery.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "contact/bake/convex/half_spaces.h"
#include "contact/bake/convex/quadric.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/convex/meshes.h"
#include "tests/support/convex/split_tree.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// The most by which a corner of the piece lies above the plane of one of its triangles.
double most_above(const SimplePiece& piece) {
  double most = 0;
  for (const auto& [a, b, c] : piece.corners) {
    const Vec3 n = cross(b - a, c - a);
    for (const auto& triangle : piece.corners) {
      for (const Vec3& p : triangle) most = std::max(most, dot(n, p - a) / norm(n));
    }
  }
  return most;
}

/// The whole surface of a level, as CGAL sees it.
CgalSurface surface_of(const std::vector<SimplePiece>& level) {
  std::map<std::array<double, 3>, uint32_t> number;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (const SimplePiece& piece : level) {
    for (const auto& corners : piece.corners) {
      Triangle& triangle = triangles.emplace_back();
      for (size_t i = 0; i < 3; ++i) {
        const Vec3& p = corners[i];
        const auto next = static_cast<uint32_t>(vertices.size());
        const auto [at, is_new] = number.try_emplace({p.x, p.y, p.z}, next);
        if (is_new) vertices.push_back(p);
        triangle[i] = at->second;
      }
    }
  }
  return cgal_surface(vertices, triangles);
}

/// Halves the pieces as often as possible; the number of pieces of each level.
std::vector<size_t> check_levels(const Soup& soup) {
  const MeshData mesh = build_mesh(soup.vertices, soup.triangles);
  const Vec3 side = mesh.upper - mesh.lower;
  const double size = std::max({side.x, side.y, side.z});
  const SurfacePieces pieces = decompose_surface(mesh.view());
  std::vector<size_t> counts{pieces.triangles.size()};
  PieceSurgery surgery(mesh.view(), pieces);
  while (counts.back() > 1 && surgery.simplify((counts.back() + 1) / 2)) {
    const std::vector<SimplePiece> level = surgery.take_level();
    CHECK(level.size() == surgery.n_pieces());
    std::vector<int> times(counts.back(), 0);
    std::set<uint32_t> triangles;
    size_t n_triangles = 0;
    double above = 0;
    for (const SimplePiece& piece : level) {
      for (const uint32_t member : piece.members) ++times.at(member);
      REQUIRE(!piece.corners.empty());
      REQUIRE(piece.triangles.size() == piece.corners.size());
      triangles.insert(piece.triangles.begin(), piece.triangles.end());
      n_triangles += piece.triangles.size();
      above = std::max(above, most_above(piece));
    }
    // each piece of the level before is in one of these, each triangle in one
    CHECK(std::all_of(times.begin(), times.end(), [](int n) { return n == 1; }));
    CHECK(triangles.size() == n_triangles);
    CHECK(above <= kPromised * size);
    const CgalSurface surface = surface_of(level);
    CHECK(surface.is_manifold);
    CHECK(surface.is_closed == mesh.closed);
    if (mesh.closed) CHECK(surface.faces_out);
    const double ratio = static_cast<double>(level.size()) / static_cast<double>(counts.back());
    // of few pieces several may vanish with one edge
    if (counts.back() > 10) CHECK((ratio >= 0.4 && ratio <= 0.6));
    counts.push_back(level.size());
  }
  return counts;
}

}  // namespace

TEST_CASE("piece surgery: pieces stay convex, closed surfaces closed, and levels halve") {
  CHECK(check_levels(make_bumpy_ball(0.02, 3, 0.05, 12)).size() > 2);
  CHECK(check_levels(make_bolt({{.grid = {24, 32}}})).size() > 2);
  CHECK(check_levels(make_dented_ball(0.02, 3, 0.5, 2e-3)).size() > 2);
  check_levels(make_torus(0.03, 0.01, 32, 16));
  check_levels(make_hole({{.grid = {32, 4}}}));
}

TEST_CASE("piece surgery: an open sheet keeps its border") {
  const Soup soup = make_rough_sheet(3, 16, 0.3);
  const MeshData mesh = build_mesh(soup.vertices, soup.triangles);
  const SurfacePieces pieces = decompose_surface(mesh.view());
  PieceSurgery surgery(mesh.view(), pieces);
  surgery.simplify(pieces.triangles.size() / 4);
  CHECK(surgery.n_pieces() < pieces.triangles.size() / 2);
  std::set<std::array<double, 3>> left;
  for (const SimplePiece& piece : surgery.take_level()) {
    for (const auto& corners : piece.corners) {
      for (const Vec3& p : corners) left.insert({p.x, p.y, p.z});
    }
  }
  size_t lost = 0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (size_t i = 0; i < 3; ++i) {
      if (mesh.view().edge_faces[mesh.view().triangle_edges[t][i]][1] != kNoFace) continue;
      const Vec3& p = mesh.vertices[mesh.triangles[t][i]];
      lost += left.contains({p.x, p.y, p.z}) ? 0 : 1;
    }
  }
  CHECK(lost == 0);
}

TEST_CASE("piece surgery: detail that is noise leaves the plane where its middle is") {
  const Soup soup = make_rough_sheet(3, 24, 0.2);
  const MeshData mesh = build_mesh(soup.vertices, soup.triangles);
  const SurfacePieces pieces = decompose_surface(mesh.view());
  PieceSurgery surgery(mesh.view(), pieces);
  surgery.simplify(pieces.triangles.size() / 8);
  double lowest = 1, highest = -1, low = 1, high = -1;
  for (const Vec3& v : mesh.vertices)
    lowest = std::min(lowest, v.z), highest = std::max(highest, v.z);
  for (const SimplePiece& piece : surgery.take_level()) {
    for (const auto& corners : piece.corners) {
      for (const Vec3& p : corners) low = std::min(low, p.z), high = std::max(high, p.z);
    }
  }
  const double height = highest - lowest;
  CHECK(low >= lowest - 0.5 * height);
  CHECK(high <= highest + 0.5 * height);
}

TEST_CASE("quadric: the planes decide where they can, the middle where they cannot") {
  Quadric corner;
  for (int i = 0; i < 3; ++i) {
    Vec3 n;
    n[i] = 1;
    corner.add({n, 0.1 * (i + 1)}, 2e-4);
  }
  CHECK(norm(filtered_minimum(corner, {5, 5, 5}, 1e-9) - Vec3{0.1, 0.2, 0.3}) < 1e-6);
  CHECK(corner.distance({0.1, 0.2, 0.3}) < 1e-8);
  // root mean square of 3, 0 and 4 mm
  CHECK(corner.distance({0.103, 0.2, 0.304}) == Approx(5e-3 / std::sqrt(3)));
  Quadric flat;
  flat.add({{0, 0, 1}, 0.1}, 1e-4);
  const Vec3 there = filtered_minimum(flat, {3, 4, 0}, 1e-9);
  CHECK(norm(there - Vec3{3, 4, 0.1}) < 1e-6);
}

TEST_CASE("half-spaces: a point is moved below all planes, if it can be, and stays if it is") {
  Random random(5);
  for (int n = 0; n < 200; ++n) {
    std::vector<Plane> planes;
    const Vec3 inside = random.in_box({-1, -1, -1}, {1, 1, 1});
    for (int i = 0; i < 20; ++i) {
      const Vec3 normal = random.direction();
      planes.push_back({normal, dot(normal, inside) + random.uniform(0.2, 1)});
    }
    CHECK(into_half_spaces(inside, planes, 1e-9) == inside);
    const Vec3 p = into_half_spaces(5 * random.direction(), planes, 1e-9);
    for (const Plane& plane : planes) CHECK(plane.above(p) <= 1e-9);
  }
}

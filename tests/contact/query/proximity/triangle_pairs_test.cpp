// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/triangle_pairs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>

#include "contact/query/box/obb_overlap.h"
#include "contact/query/triangle/orientation.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

using TrianglePairs = std::vector<std::pair<uint32_t, uint32_t>>;

TrianglePairs pairs_of(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB) {
  std::vector<TrianglePair> out(triangle_pairs(A.view(), B.view(), X_AB, {}));
  REQUIRE(triangle_pairs(A.view(), B.view(), X_AB, out) == out.size());
  TrianglePairs pairs;
  for (const TrianglePair& pair : out) pairs.emplace_back(pair.a, pair.b);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<Corners> all_corners(const MeshShapeData& shape, const Pose& X) {
  std::vector<Corners> corners;
  const TriangleMesh mesh = shape.mesh.view();
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) corners.push_back(corners_of(mesh, t, X));
  return corners;
}

/// All pairs of triangles.
TrianglePairs all_meeting(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB) {
  const std::vector<Corners> in_A = all_corners(A, {}), in_B = all_corners(B, X_AB);
  TrianglePairs pairs;
  for (uint32_t a = 0; a < in_A.size(); ++a) {
    for (uint32_t b = 0; b < in_B.size(); ++b) {
      if (triangles_meet(in_A[a], in_B[b])) pairs.emplace_back(a, b);
    }
  }
  return pairs;
}

TrianglePairs by_cgal(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB) {
  return cgal_triangle_pairs(all_corners(A, {}), all_corners(B, X_AB));
}

Soup moved(Soup soup, const Pose& X) {
  for (Vec3& v : soup.vertices) v = X * v;
  return soup;
}

/// Corners of a cubic lattice: touching, sharing and coplanar triangles are common.
Corners on_lattice(Random& random, size_t n) {
  Corners corners;
  for (Vec3& p : corners) {
    for (int i = 0; i < 3; ++i) p[i] = static_cast<double>(random.index(n));
  }
  return corners;
}

bool has_area(const Corners& c) {
  return norm_squared(cross(c[1] - c[0], c[2] - c[0])) > 0;
}

}  // namespace

TEST_CASE("orientation: the sign of the determinant in whole numbers, on and beside the plane") {
  Random random(1);
  const double reach = 0x1p38;
  __extension__ typedef __int128 Whole;
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    Vec3 p[4];
    for (Vec3& v : p) {
      v = random.in_box({-reach, -reach, -reach}, {reach, reach, reach});
      for (int i = 0; i < 3; ++i) v[i] = std::floor(v[i]);
    }
    // in the plane of the others, or one unit beside it
    if (trial % 2 == 0) {
      p[3] = 3 * (p[1] - p[0]) - 2 * (p[2] - p[0]) + p[0];
      if (trial % 4 == 0) p[3][static_cast<int>(random.index(3))] += 1;
    }
    const auto d = [&](int k, int i) {
      return static_cast<Whole>(p[k][i]) - static_cast<Whole>(p[3][i]);
    };
    Whole determinant = 0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      determinant += d(0, i) * (d(1, j) * d(2, k) - d(1, k) * d(2, j));
    }
    const int expected = determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
    REQUIRE(orientation(p[0], p[1], p[2], p[3]) == expected);
    const Whole turn = (static_cast<Whole>(p[1].x) - static_cast<Whole>(p[0].x)) *
                           (static_cast<Whole>(p[2].y) - static_cast<Whole>(p[0].y)) -
                       (static_cast<Whole>(p[1].y) - static_cast<Whole>(p[0].y)) *
                           (static_cast<Whole>(p[2].x) - static_cast<Whole>(p[0].x));
    REQUIRE(orientation(Point2{p[0].x, p[0].y}, Point2{p[1].x, p[1].y}, Point2{p[2].x, p[2].y}) ==
            (turn > 0   ? 1
             : turn < 0 ? -1
                        : 0));
  }
  CHECK(orientation(Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, -1}) == 1);
}

TEST_CASE("triangles meet: as CGAL says, touching and in one plane too") {
  Random random(2);
  size_t n_meeting = 0, n_tests = 0;
  for (size_t trial = 0; trial < trials(40000); ++trial) {
    const size_t fine = trial % 3 == 0 ? 3 : trial % 3 == 1 ? 4 : 1000;
    Corners a = on_lattice(random, fine), b = on_lattice(random, fine);
    if (!has_area(a) || !has_area(b)) continue;
    // off the lattice, rounded: nearly touching, nearly coplanar
    if (trial % 5 == 0) {
      const Pose X = random.pose(0.1);
      for (Vec3& p : a) p = X * p;
      for (Vec3& p : b) p = X * p;
    }
    const bool expected = cgal_triangles_meet(a, b);
    CAPTURE(trial);
    REQUIRE(triangles_meet(a, b) == expected);
    REQUIRE(triangles_meet(b, a) == expected);
    REQUIRE(triangles_meet({a[2], a[0], a[1]}, {b[1], b[0], b[2]}) == expected);
    n_meeting += expected, ++n_tests;
  }
  CHECK(n_meeting > n_tests / 10);
  CHECK(n_meeting < n_tests * 9 / 10);
}

TEST_CASE("triangles meet: a corner on a face, an edge on an edge, one inside another") {
  const Corners a{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
  CHECK(triangles_meet(a, {{{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}}));          // corner on the face
  CHECK(triangles_meet(a, {{{2, 2, -1}, {2, 2, 1}, {5, 5, 0}}}));         // edge on an edge
  CHECK(triangles_meet(a, {{{4, 0, 0}, {5, 0, 1}, {5, 0, 0}}}));          // corner on a corner
  CHECK(triangles_meet(a, {{{1, 1, 0}, {1.5, 1, 0}, {1, 1.5, 0}}}));      // inside, coplanar
  CHECK(triangles_meet(a, {{{0, 0, 0}, {4, 0, 0}, {0, -4, 0}}}));         // share an edge
  CHECK(triangles_meet(a, {{{1, 0, 0}, {2, 0, 0}, {1, 0, 1}}}));          // edge along an edge
  CHECK_FALSE(triangles_meet(a, {{{1, 1, 1}, {1.5, 1, 1}, {1, 2, 1}}}));  // parallel
  CHECK_FALSE(triangles_meet(a, {{{3, 3, 0}, {4, 3, 0}, {3, 4, 0}}}));    // beside, coplanar
  CHECK_FALSE(triangles_meet(a, {{{1, 1, 0}, {2, 1, 0}, {3, 1, 0}}}));    // without area
  CHECK_FALSE(triangles_meet(a, {{{1, 1, -1}, {1, 1, 1}, {1, 1, 3}}}));   // without area, across
}

TEST_CASE("triangle pairs: all that brute force and CGAL find, at random poses") {
  Random random(3);
  const MeshShapeData box = build_shape(make_box({0.06, 0.04, 0.05}));
  const MeshShapeData sphere = build_shape(make_icosphere(0.03, 2));
  const MeshShapeData sheet = build_shape(make_rough_sheet(4, 12, 0.5));
  const MeshShapeData* const shapes[] = {&box, &sphere, &sheet};
  size_t n_pairs = 0;
  for (size_t trial = 0; trial < trials(120); ++trial) {
    const MeshShapeData &A = *shapes[random.index(3)], &B = *shapes[random.index(3)];
    const Pose X_AB = random.pose(random.uniform(0, 0.06));
    const TrianglePairs pairs = pairs_of(A, B, X_AB);
    REQUIRE(pairs == all_meeting(A, B, X_AB));
    REQUIRE(pairs == by_cgal(A, B, X_AB));
    n_pairs += pairs.size();
  }
  CHECK(n_pairs > 0);
}

TEST_CASE("triangle pairs: in one plane and edge on edge nothing is missed") {
  // axes of the boxes are parallel: their cross products vanish
  const MeshShapeData sheet = build_shape(make_grid(0.05, 8));
  const MeshShapeData box = build_shape(make_box({0.05, 0.05, 0.05}));
  size_t n_pairs = 0;
  for (const Vec3& p : {Vec3{}, Vec3{0.0125, 0, 0}, Vec3{0.1, 0, 0}, Vec3{0.1, 0.1, 0},
                        Vec3{0, 0, 0.025}, Vec3{0.075, 0.075, 0.025}}) {
    for (const MeshShapeData* B : {&sheet, &box}) {
      const TrianglePairs pairs = pairs_of(sheet, *B, {p, {}});
      n_pairs += pairs.size();
      CHECK(pairs == all_meeting(sheet, *B, {p, {}}));
      CHECK(pairs == by_cgal(sheet, *B, {p, {}}));
    }
  }
  CHECK(n_pairs > 1000);
  CHECK(pairs_of(sheet, sheet, {{0.1 + 1e-9, 0, 0}, {}}).empty());
}

TEST_CASE("triangle pairs: soups without order, far from the origin, and of very unlike size") {
  Random random(5);
  const MeshShapeData soup = build_shape(make_degenerate_soup(6, 100));
  const MeshShapeData tiny = build_shape(moved(make_icosphere(1e-6, 1), {{1000, -500, 200}, {}}));
  const MeshShapeData needle = build_shape(moved(make_box({2, 1e-7, 1e-5}), random.pose(0.1)));
  for (size_t trial = 0; trial < trials(20); ++trial) {
    const Pose X = random.pose(0.3);
    CHECK(pairs_of(soup, needle, X) == all_meeting(soup, needle, X));
    CHECK(pairs_of(soup, soup, X) == all_meeting(soup, soup, X));
    // tiny ball onto a point of the soup's surface
    const Vec3 target = random.on_surface(soup.mesh.view());
    const Pose turned = random.pose(1);
    const Pose onto{target - rotate(turned.q, {1000, -500, 200}), turned.q};
    CHECK(pairs_of(soup, tiny, onto) == all_meeting(soup, tiny, onto));
  }
}

TEST_CASE("triangle pairs: boxes in floats that share a point are never told apart") {
  Random random(7);
  const MeshShapeData ball = build_shape(make_icosphere(0.05, 2));
  const MeshShapeData sheet = build_shape(make_rough_sheet(8, 6, 1e-3));
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    const CompactObb& a = ball.tree.nodes[random.index(ball.tree.nodes.size())].box;
    const CompactObb& b = sheet.tree.nodes[random.index(sheet.tree.nodes.size())].box;
    // one corner of each at the same place, turned at random
    const auto corner = [&](const CompactObb& compact) {
      const Obb box = compact.unpacked();
      Vec3 q;
      for (int i = 0; i < 3; ++i) q[i] = (random.index(2) == 0 ? -1 : 1) * box.half[i];
      return box.centre_O + transpose(box.R_BO) * q;
    };
    const Quat q_AB = trial % 2 == 0 ? Quat{} : random.pose(1).q;
    const Pose X_AB{corner(a) - rotate(q_AB, corner(b)), q_AB};
    REQUIRE(boxes_may_meet(a, b, at_rest(X_AB)));
  }
}

TEST_CASE("triangle pairs: bunny on bunny as CGAL") {
  const Soup soup = load_off("bunny00.off", 0.1);
  if (soup.triangles.empty() || kSlowdown > 1) return;
  const MeshShapeData bunny = build_shape(soup);
  Random random(9);
  for (int trial = 0; trial < 3; ++trial) {
    const Pose X_AB = random.pose(0.05);
    const TrianglePairs pairs = pairs_of(bunny, bunny, X_AB);
    CHECK(pairs.size() > 100);
    CHECK(pairs == by_cgal(bunny, bunny, X_AB));
  }
}

TEST_CASE("triangle pairs: numbering and common motion do not matter") {
  Random random(10);
  const Soup sphere = make_icosphere(0.03, 2), sheet = make_rough_sheet(11, 10, 0.5);
  const MeshShapeData A = build_shape(sheet), B = build_shape(sphere);
  for (size_t trial = 0; trial < trials(10); ++trial) {
    const Pose X_AB = random.pose(0.02), X = random.pose(0.5);
    const TrianglePairs pairs = pairs_of(A, B, X_AB);
    // both frames moved in their meshes: X_A'B' = X X_AB X'⁻¹
    const Pose X_other = random.pose(0.5);
    const MeshShapeData A_moved = build_shape(moved(sheet, X));
    const MeshShapeData B_moved = build_shape(moved(sphere, X_other));
    REQUIRE(pairs_of(A_moved, B_moved, X * X_AB * inverse(X_other)) == pairs);
    // triangle k of the shuffled soup is triangle from[k] of the other
    std::vector<uint32_t> from(sphere.triangles.size());
    std::iota(from.begin(), from.end(), 0u);
    for (size_t i = from.size(); i > 1; --i) std::swap(from[i - 1], from[random.index(i)]);
    Soup shuffled = sphere;
    for (size_t k = 0; k < from.size(); ++k) {
      const Triangle& t = sphere.triangles[from[k]];
      shuffled.triangles[k] = {t[1], t[2], t[0]};
    }
    TrianglePairs renamed = pairs_of(A, build_shape(shuffled), X_AB);
    for (auto& [a, b] : renamed) b = from[b];
    std::sort(renamed.begin(), renamed.end());
    REQUIRE(renamed == pairs);
  }
}

TEST_CASE("triangle pairs: what does not fit is counted, and bad poses meet nothing") {
  const MeshShapeData box = build_shape(make_box({0.05, 0.05, 0.05}));
  const Pose X{{0.01, 0.02, 0.005}, from_rotation_vector({0.1, 0.2, 0.3})};
  std::vector<TrianglePair> all(1000);
  const size_t n = triangle_pairs(box.view(), box.view(), X, all);
  REQUIRE(n > 4);
  std::vector<TrianglePair> few(4);
  CHECK(triangle_pairs(box.view(), box.view(), X, few) == n);
  CHECK(std::equal(few.begin(), few.end(), all.begin()));

  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(triangle_pairs(box.view(), box.view(), {{nan, 0, 0}, {}}, all) == 0);
  CHECK(triangle_pairs(box.view(), build_shape({}).view(), {}, all) == 0);
}

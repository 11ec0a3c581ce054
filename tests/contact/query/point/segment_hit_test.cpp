// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/point/segment_hit.h"

#include <catch2/catch.hpp>

#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

// tolerance of the position along a segment, if the same triangle is hit with other roundings
constexpr double kFractionTolerance = 1e-9;
// margin of the box test, for boxes and segments of a few metres
constexpr double kBoxSlack = 1e-4;

/// All triangles, without a tree.
SegmentHit brute_hit(const TriangleMesh& mesh, const Vec3& from, const Vec3& to) {
  SegmentHit best;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    double t = 0;
    if (segment_enters_triangle(from, to, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c],
                                t) &&
        (!best.hit || t < best.t)) {
      best = {true, t, i};
    }
  }
  return best;
}

bool same_hit(const SegmentHit& a, const SegmentHit& b) {
  return a.hit == b.hit && (!a.hit || (a.t == b.t && a.triangle == b.triangle));
}

/// By the cells, by the tree alone, and begun at whatever was hit last.
void compare_with_brute_force(const Soup& soup, uint64_t seed, size_t n) {
  const MeshShapeData shape = build_shape(soup);
  MeshShapeData without_grid = shape;
  without_grid.grid = {};
  const TriangleMesh mesh = shape.mesh.view();
  const double size = norm(mesh.upper - mesh.lower);
  Random random(seed);
  SegmentWitness witness;
  Vec3 before = random.on_surface(mesh);
  for (size_t i = 0; i < n; ++i) {
    // dragged, as in use, and as often long ones or short ones at the surface, some along the axes
    Vec3 from = before,
         to = i % 40 == 0 ? random.on_surface(mesh) : before + 0.02 * size * random.direction();
    before = to;
    if (i % 4 == 1) from = random.near_mesh(mesh), to = random.near_mesh(mesh);
    if (i % 4 == 3) {
      from = random.on_surface(mesh) + 0.01 * size * random.direction();
      to = from + 0.03 * size * random.direction();
    }
    if (i % 11 == 0) to = {from.x, from.y, to.z};
    // at times with the warm start of another mesh
    if (i % 97 == 0) witness.triangle = static_cast<uint32_t>(random.index(1u << 31));
    if (i % 89 == 0) witness.slot = random.index(2 * shape.view().grid.slots.size());
    const SegmentHit slow = brute_hit(mesh, from, to);
    CAPTURE(i, from, to, slow.t, slow.triangle);
    REQUIRE(same_hit(first_hit(shape.view(), from, to, witness), slow));
    REQUIRE(same_hit(first_hit(shape.view(), from, to), slow));
    REQUIRE(same_hit(first_hit(without_grid.view(), from, to), slow));
  }
}

/// Slab clipping of a segment in the frame of the box.
bool slabs_meet(const Vec3& from, const Vec3& to, const Obb& box) {
  const Vec3 p = box.R_BO * (from - box.centre_O), d = box.R_BO * (to - from);
  double enter = 0, leave = 1;
  for (int i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (std::fabs(p[i]) > box.half[i]) return false;
      continue;
    }
    const double a = (-box.half[i] - p[i]) / d[i], b = (box.half[i] - p[i]) / d[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

/// Segments through exact vertices and exact points of edges, from outside to inside: the worst
/// places for cracks. `depth` must keep both ends clear of the rest of the surface.
void never_slips(const MeshShapeData& shape, double depth, uint64_t seed, size_t n) {
  Random random(seed);
  const MeshShape view = shape.view();
  const TriangleMesh& mesh = view.mesh;
  for (size_t i = 0; i < n; ++i) {
    const Triangle& tri = mesh.triangles[random.index(mesh.triangles.size())];
    const Vec3 &a = mesh.vertices[tri[0]], &b = mesh.vertices[tri[1]];
    const double u = i % 2 == 0 ? 0 : random.uniform(0, 1);
    const Vec3 aim = a + u * (b - a);
    // the target divides the segment at random; half of them run towards the centre
    Vec3 inward = -normalized(aim);
    if (i % 4 >= 2) inward = normalized(inward + 0.5 * random.direction());
    const Vec3 from = aim - random.uniform(0.1, 1) * depth * inward;
    const Vec3 to = aim + random.uniform(0.1, 1) * depth * inward;
    const SegmentHit hit = first_hit(view, from, to);
    if (hit.hit) continue;
    CAPTURE(i, from, to, aim);
    FAIL("slipped through at an edge or a vertex");
  }
}

}  // namespace

TEST_CASE("segment hit: the tree finds what brute force finds") {
  compare_with_brute_force(make_box({0.1, 0.2, 0.05}), 1, trials(20000));
  compare_with_brute_force(make_grid(0.05, 12), 3, trials(8000));
  // HAPTIC_TORTURE_SCALE=250 makes it 10^6 segments a mesh
  Soup waves = make_grid(0.05, 12);
  for (Vec3& v : waves.vertices) v.z = 0.01 * std::sin(90 * v.x) * std::cos(70 * v.y);
  for (const Soup& soup : {make_icosphere(0.05, 2), waves, make_degenerate_soup(6, 300)}) {
    compare_with_brute_force(soup, 14, sweep(4000));
  }
  // closely spaced sheets: the first hit hides many
  Soup sheets;
  for (int k = 0; k < 30; ++k) append(sheets, make_grid(0.05, 4), {0, 0, 0.001 * k});
  compare_with_brute_force(sheets, 6, trials(8000));
  const Soup bunny = load_off("bunny00.off", 0.1);
  if (!bunny.triangles.empty()) compare_with_brute_force(bunny, 5, trials(300));
}

TEST_CASE("segment hit: no segment slips between triangles that share an edge or a vertex") {
  never_slips(build_shape(make_icosphere(0.05, 4)), 0.02, 6, trials(1500000));
  never_slips(build_shape(make_icosphere(1, 1)), 0.3, 7, trials(500000));
  never_slips(build_shape(make_box({1, 1, 1})), 0.3, 8, trials(500000));
  // far from the origin the vertices are coarse, but shared
  Soup away = make_icosphere(0.05, 3);
  for (Vec3& v : away.vertices) v += Vec3{1e3, -2e3, 5e2};
  const MeshShapeData shape = build_shape(away);
  Random random(9);
  for (size_t i = 0; i < trials(200000); ++i) {
    const Vec3& aim = shape.mesh.vertices[random.index(shape.mesh.vertices.size())];
    const Vec3 centre{1e3, -2e3, 5e2};
    REQUIRE(first_hit(shape.view(), aim + 0.5 * (aim - centre), centre).hit);
  }
}

TEST_CASE("segment hit: axis-parallel segments through lattice vertices never slip") {
  // many projected coordinates are exactly zero here: every edge test is a tie
  const MeshShapeData shape = build_shape(make_grid(1, 16));
  for (const auto& v : shape.mesh.vertices) {
    if (std::fabs(v.x) == 1 || std::fabs(v.y) == 1) continue;
    const SegmentHit hit = first_hit(shape.view(), v + Vec3{0, 0, 1}, v - Vec3{0, 0, 1});
    REQUIRE(hit.hit);
    REQUIRE(hit.t == 0.5);
    REQUIRE_FALSE(first_hit(shape.view(), v - Vec3{0, 0, 1}, v + Vec3{0, 0, 1}).hit);
  }
}

TEST_CASE("segment hit: beside an edge by less than a rounding only one side is hit") {
  // the edge a b passes the axis at about e²: the two products of its volume round to one number
  constexpr double e = 0x1p-52;
  const Vec3 a{1 + 2 * e, 1 + e, 0}, b{-(1 + e), -1, 0}, left{1, -1, 0}, right{-1, 1, 0};
  const Vec3 from{0, 0, 1}, to{0, 0, -1};
  double t = 0;
  CHECK(segment_enters_triangle(from, to, a, b, left, t));
  CHECK_FALSE(segment_enters_triangle(from, to, b, a, right, t));
}

TEST_CASE("segment hit: only front faces count") {
  const MeshShapeData shape = build_shape(make_box({2, 2, 2}));
  CHECK(first_hit(shape.view(), {3, 0.1, 0.2}, {0, 0.1, 0.2}).t == Approx(2.0 / 3));
  CHECK_FALSE(first_hit(shape.view(), {0, 0.1, 0.2}, {3, 0.1, 0.2}).hit);
  // straight through: the near face
  CHECK(first_hit(shape.view(), {3, 0.1, 0.2}, {-3, 0.1, 0.2}).t == Approx(1.0 / 3));
}

TEST_CASE("segment hit: a zero-length, an empty and a non-finite query hit nothing") {
  const MeshShapeData shape = build_shape(make_box({2, 2, 2}));
  CHECK_FALSE(first_hit(shape.view(), {1, 0, 0}, {1, 0, 0}).hit);
  CHECK_FALSE(first_hit(shape.view(), {0, 0, 0}, {0, 0, 0}).hit);
  CHECK_FALSE(first_hit(build_shape({}).view(), {3, 0, 0}, {0, 0, 0}).hit);
  const double nan = std::nan("");
  CHECK_FALSE(first_hit(shape.view(), {3, nan, 0}, {0, 0, 0}).hit);
  CHECK_FALSE(first_hit(shape.view(), {3, 0, 0}, {0, 0, nan}).hit);
  double t = 0;
  CHECK_FALSE(segment_enters_triangle({0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, t));
}

TEST_CASE("segment hit: equal hits go to the lower triangle") {
  Soup twice = make_grid(1, 1);
  twice.triangles.insert(twice.triangles.begin(), twice.triangles.begin(), twice.triangles.end());
  const MeshShapeData shape = build_shape(twice);
  CHECK(first_hit(shape.view(), {0.5, -0.25, 1}, {0.5, -0.25, -1}).triangle == 0);
  // on the diagonal all four triangles tie
  CHECK(first_hit(shape.view(), {0.25, 0.25, 1}, {0.25, 0.25, -1}).triangle == 0);
}

TEST_CASE("segment hit: a rigid motion of everything changes nothing") {
  const Soup sphere = make_icosphere(0.05, 3);
  const MeshShapeData still = build_shape(sphere);
  Random random(10);
  for (int motion = 0; motion < 5; ++motion) {
    const Pose X = random.pose(0.5);
    Soup turned = sphere;
    for (Vec3& v : turned.vertices) v = X * v;
    const MeshShapeData moved = build_shape(turned);
    for (size_t i = 0; i < trials(2000); ++i) {
      const Vec3 from = random.near_mesh(still.mesh.view()),
                 to = random.near_mesh(still.mesh.view());
      const SegmentHit a = first_hit(still.view(), from, to);
      const SegmentHit b = first_hit(moved.view(), X * from, X * to);
      REQUIRE(a.hit == b.hit);
      REQUIRE(std::fabs(a.t - b.t) < tol(kFractionTolerance));
    }
  }
}

TEST_CASE("segment hit: a plane is hit where the closed form says") {
  const MeshShapeData grid = build_shape(make_grid(1, 9));
  Random random(11);
  for (size_t i = 0; i < trials(20000); ++i) {
    const Vec3 from = random.in_box({-0.9, -0.9, 0.01}, {0.9, 0.9, 1});
    const Vec3 to = random.in_box({-0.9, -0.9, -1}, {0.9, 0.9, -0.01});
    const SegmentHit hit = first_hit(grid.view(), from, to);
    REQUIRE(hit.hit);
    REQUIRE(std::fabs(hit.t - from.z / (from.z - to.z)) < tol(kFractionTolerance));
  }
}

TEST_CASE("segment hit: the box test agrees with slab clipping up to its slack") {
  Random random(12);
  size_t met = 0;
  for (size_t i = 0; i < trials(200000); ++i) {
    CompactObb compact;
    const Mat3 R = to_matrix(random.pose(1).q);
    const Vec3 centre = random.direction(), half = random.in_box({0, 0, 0}, {1, 1, 1});
    for (int k = 0; k < 9; ++k) compact.columns_BO[k] = static_cast<float>(R.row[k % 3][k / 3]);
    for (int k = 0; k < 3; ++k) compact.centre_O[k] = static_cast<float>(centre[k]);
    for (int k = 0; k < 3; ++k) compact.half[k] = static_cast<float>(half[k]);
    if (i % 7 == 0) compact.half[2] = 0;
    const Vec3 from = 3 * random.direction(), to = random.in_box({-3, -3, -3}, {3, 3, 3});
    const Obb box = compact.unpacked();
    Obb grown = box;
    grown.half += Vec3{kBoxSlack, kBoxSlack, kBoxSlack};
    const bool meets = segment_meets_box(from, to, compact);
    CAPTURE(i, from, to, box.centre_O, box.half);
    REQUIRE(meets >= slabs_meet(from, to, box));
    REQUIRE(meets <= slabs_meet(from, to, grown));
    met += meets;
  }
  CHECK(met > trials(200000) / 20);
  // a point is in the box or it is not
  CompactObb unit;
  unit.columns_BO = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  unit.half = {1, 1, 1};
  CHECK(segment_meets_box({0.5, 0.5, 1}, {0.5, 0.5, 1}, unit));
  CHECK_FALSE(segment_meets_box({0.5, 0.5, 1.001}, {0.5, 0.5, 1.001}, unit));
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/query/sweep/swept_sphere.cpp.
#include "contact/query/sweep/swept_sphere.h"

#include "contact/query/point/closest_point.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kFar = 1e9;

/// All triangles, with the same arithmetic.
SegmentHit earliest_of_all(const MeshShape& shape, const SweptSphere& sphere) {
  SegmentHit best;
  for (uint32_t i = 0; i < shape.mesh.triangles.size(); ++i) {
    double t = 1;
    if (!sphere_enters_triangle(shape.mesh, i, sphere, t)) continue;
    if (!best.hit || t < best.t) best = {true, t, i};
  }
  return best;
}

/// Requires a hit to be another one to the last bit.
void require_same(const SegmentHit& hit, const SegmentHit& expected) {
  REQUIRE(hit.hit == expected.hit);
  REQUIRE(hit.t == expected.t);
  REQUIRE(hit.triangle == expected.triangle);
}

double distance_at(const MeshShape& shape, const SweptSphere& s, double t) {
  return closest_point(shape, s.from_O + t * (s.to_O - s.from_O), kFar).distance;
}

}  // namespace

TEST_CASE("swept sphere: face, edge and vertex of a box by closed form", "[contact]") {
  const MeshShapeData box = build_shape(make_box({2, 2, 2}));
  const double r = 0.25;
  struct Row {
    Vec3 from, to;
    double t;
  };
  // straight at the edge x = z = 1, and off its middle plane; at the vertex (1, 1, 1)
  const std::vector<Row> rows{
      {{0.3, 0.2, 3}, {0.3, 0.2, 0}, (2 - r) / 3},
      {{2, 0.1, 2}, {0, 0.1, 0}, (std::sqrt(2.0) - r) / std::sqrt(8.0)},
      {{3, 0.1, 1.15}, {0, 0.1, 1.15}, (2 - std::sqrt(r * r - 0.15 * 0.15)) / 3},
      {{2, 2, 2}, {0, 0, 0}, (std::sqrt(3.0) - r) / std::sqrt(12.0)}};
  for (const Row& row : rows) {
    const SegmentHit hit = first_sphere_hit(box.view(), {row.from, row.to, r});
    CHECK(hit.hit);
    CHECK(std::fabs(hit.t - row.t) <= tol(1e-15));
  }
  CHECK_FALSE(first_sphere_hit(box.view(), {{3, 0, 1.2501}, {-3, 0, 1.2501}, r}).hit);
  CHECK_FALSE(first_sphere_hit(box.view(), {{0, 0, 3}, {0, 0, 3}, r}).hit);
}

TEST_CASE("swept sphere: what overlaps already is hit at once, but may leave", "[contact]") {
  const MeshShapeData box = build_shape(make_box({2, 2, 2}));
  const SegmentHit hit = first_sphere_hit(box.view(), {{0, 0, 1.1}, {0, 0, 0.5}, 0.25});
  CHECK(hit.hit);
  CHECK(hit.t == 0);
  CHECK_FALSE(first_sphere_hit(box.view(), {{0, 0, 1.1}, {0, 0, 3}, 0.25}).hit);
}

TEST_CASE("swept sphere: a surface is open from behind", "[contact]") {
  const MeshShapeData grid = build_shape(make_grid(1, 4));
  CHECK(first_sphere_hit(grid.view(), {{0.13, 0.17, 1}, {0.13, 0.17, -1}, 0.1}).hit);
  CHECK_FALSE(first_sphere_hit(grid.view(), {{0.13, 0.17, -1}, {0.13, 0.17, 1}, 0.1}).hit);
}

TEST_CASE("swept sphere: the tree finds what every triangle in turn finds", "[contact]") {
  const double radius = GENERATE(0.001, 0.02, 0.3);
  const MeshShapeData sphere = build_shape(make_icosphere(1, 3));
  const MeshShapeData soup = build_shape(make_degenerate_soup(4, 300));
  Random random(7);
  size_t hits = 0;
  for (size_t k = 0; k < trials(2000); ++k) {
    for (const MeshShapeData* shape : {&sphere, &soup}) {
      const Vec3 from = random.near_mesh(shape->view().mesh);
      const double length = k % 2 == 0 ? 2 : 0.05;
      const SweptSphere s{from, from + length * random.direction(), radius};
      const SegmentHit tree = first_sphere_hit(shape->view(), s);
      CAPTURE(k, radius, s.from_O, s.to_O);
      require_same(tree, earliest_of_all(shape->view(), s));
      hits += tree.hit;
    }
  }
  CHECK(hits > trials(2000) / 40);
}

TEST_CASE("swept sphere: on rough sheets, small and large spheres, near and far from the origin",
          "[contact]") {
  Random random(17);
  size_t hits = 0;
  for (size_t k = 0; k < trials(60); ++k) {
    const double slope = random.uniform(0.1, 3);
    Soup sheet = make_rough_sheet(k, 10, slope);
    const Vec3 shift = k % 2 == 0 ? Vec3{} : random.in_box({-3, -3, -3}, {3, 3, 3});
    for (Vec3& v : sheet.vertices) v = v + shift;
    const MeshShapeData shape = build_shape(sheet);
    for (int i = 0; i < 20; ++i) {
      const double radius = std::pow(10, random.uniform(-4, -1));
      const Vec3 on = random.on_surface(shape.view().mesh);
      const Vec3 from = on + random.uniform(0.5, 1.5) * radius * random.direction();
      const double length = std::pow(10, random.uniform(-6, -1));
      const SweptSphere s{from, from + length * random.direction(), radius};
      const SegmentHit tree = first_sphere_hit(shape.view(), s);
      CAPTURE(k, i, slope, radius, s.from_O, s.to_O);
      require_same(tree, earliest_of_all(shape.view(), s));
      hits += tree.hit;
    }
  }
  CHECK(hits > trials(60));
}

TEST_CASE("swept sphere: a witness never changes a result", "[contact][trap]") {
  const MeshShapeData shape = build_shape(make_icosphere(1, 3));
  Random random(19);
  SegmentWitness stale;
  for (size_t k = 0; k < trials(3000); ++k) {
    const Vec3 from = random.near_mesh(shape.view().mesh);
    const SweptSphere s{from, from + random.uniform(0, 2) * random.direction(), 0.3};
    // warm start from the last hit, from any triangle, and from one of another mesh
    SegmentWitness foreign{k % 3 == 0 ? ~0u - 1 : static_cast<uint32_t>(random.index(1280))};
    const SegmentHit expected = first_sphere_hit(shape.view(), s);
    for (SegmentWitness* witness : {&stale, &foreign}) {
      CAPTURE(k, s.from_O, s.to_O);
      require_same(first_sphere_hit(shape.view(), s, *witness), expected);
    }
  }
}

TEST_CASE("swept sphere: the first hit is where the distance comes down to the radius",
          "[contact][property]") {
  // against the closest point, which is independent of sweeps
  const double radius = GENERATE(0.005, 0.05, 0.4);
  const MeshShapeData shape = build_shape(make_icosphere(1, 2));
  Random random(11);
  size_t hits = 0;
  for (size_t k = 0; k < trials(1500); ++k) {
    const Vec3 from = (1 + radius + random.uniform(0.001, 1)) * random.direction();
    if (closest_point(shape.view(), from, kFar).distance <= radius) continue;
    const SweptSphere s{from, from + random.uniform(0.1, 3) * random.direction(), radius};
    const SegmentHit hit = first_sphere_hit(shape.view(), s);
    CAPTURE(k, radius, s.from_O, s.to_O, hit.t);
    if (hit.hit) {
      ++hits;
      REQUIRE(std::fabs(distance_at(shape.view(), s, hit.t) - radius) <= tol(1e-13));
    }
    const double end = hit.hit ? hit.t : 1;
    for (int i = 0; i <= 20; ++i) {
      REQUIRE(distance_at(shape.view(), s, end * i / 20) >= radius - tol(1e-13));
    }
  }
  CHECK(hits > trials(1500) / 10);
}

TEST_CASE("swept sphere: nothing slips between features that meet", "[contact][trap]") {
  // straight at vertices and at points of edges
  const MeshShapeData shape = build_shape(make_icosphere(1, 2));
  const auto mesh = shape.view().mesh;
  Random random(13);
  for (size_t k = 0; k < trials(4000); ++k) {
    const Triangle& t = mesh.triangles[random.index(mesh.triangles.size())];
    const double share = k % 3 == 0 ? 0.0 : random.uniform(0, 1);
    const Vec3 target = mesh.vertices[t[0]] + share * (mesh.vertices[t[1]] - mesh.vertices[t[0]]);
    const Vec3 from = 3.0 * normalized(target) + 0.5 * random.direction();
    const SegmentHit hit = first_sphere_hit(shape.view(), {from, Vec3{}, 0.01});
    CAPTURE(k, from, target);
    REQUIRE(hit.hit);
    REQUIRE(std::fabs(distance_at(shape.view(), {from, Vec3{}, 0.01}, hit.t) - 0.01) <= tol(1e-13));
  }
}

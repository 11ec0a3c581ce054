// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/hull_of_points.h"

#include <algorithm>
#include <limits>
#include <random>

#include "proto/math/pose.h"
#include "proto/os/message.h"
#include "tests/support/convex/hulls.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

constexpr double kSize = 0.04;               // of the shapes [m]
constexpr double kTolerance = 1e-7 * kSize;  // as hull_of_points() states it

/// A cube's corners, its centre, and points in its faces and on its edges.
std::vector<Vec3> cube_points(const Pose& X) {
  std::vector<Vec3> points;
  for (int i = 0; i < 125; ++i) {
    points.push_back(X *
                     (kSize * Vec3{i % 5 / 4.0 - 0.5, i / 5 % 5 / 4.0 - 0.5, i / 25 / 4.0 - 0.5}));
  }
  return points;
}

void check_sound(const PointsHull& made, std::span<const Vec3> points) {
  const char* defect = hull_defect(made.hull.view(), kTolerance);
  CHECK((defect == nullptr ? "" : std::string(defect)) == "");
  for (const HullFace& face : made.hull.faces) {
    for (const Vec3& p : points) CHECK(dot(face.normal, p) - face.offset <= kTolerance);
    CHECK(face.is_virtual == 0);
    CHECK(face.triangle == kNoTriangle);
  }
  REQUIRE(made.point_of.size() == made.hull.vertices.size());
  for (size_t v = 0; v < made.point_of.size(); ++v) {
    CHECK(made.hull.vertices[v] == points[made.point_of[v]]);
  }
}

}  // namespace

TEST_CASE("hull of points: points on a sphere are all its vertices", "[convex]") {
  std::mt19937_64 engine(1);
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i) points.push_back(kSize / 2 * random_direction(engine));
  const PointsHull made = hull_of_points(points);
  check_sound(made, points);
  CHECK(made.hull.vertices.size() == 200);
  CHECK(made.hull.faces.size() == 2 * 200 - 4);
}

TEST_CASE("hull of points: coplanar triangles are one polygon, also in a turned cube", "[convex]") {
  const Pose X = GENERATE(Pose{}, Pose{{0.1, 0.2, -0.3}, from_rotation_vector({0.3, -0.8, 0.4})},
                          Pose{{5, 5, 5}, from_rotation_vector({2, 1, 0.1})});
  const std::vector<Vec3> points = cube_points(X);
  const PointsHull made = hull_of_points(points);
  check_sound(made, points);
  CHECK(made.hull.vertices.size() == 8);
  CHECK(made.hull.faces.size() == 6);
  CHECK(made.hull.edges.size() == 24);
  for (const HullFace& face : made.hull.faces) {
    CHECK(face.n_edges == 4);
    CHECK_THAT(face.offset - dot(face.normal, X.p), Catch::Matchers::WithinAbs(kSize / 2, 1e-12));
  }
}

TEST_CASE("hull of points: a flat set has two sides", "[convex]") {
  const Pose X = GENERATE(Pose{}, Pose{{0.1, 0.2, -0.3}, from_rotation_vector({0.3, -0.8, 0.4})});
  std::vector<Vec3> points;
  for (int i = 0; i < 6; ++i) {
    const double angle = i * M_PI / 3;
    points.push_back(X * (kSize / 2 * Vec3{std::cos(angle), std::sin(angle), 0}));
    points.push_back(X * (kSize / 5 * Vec3{std::cos(angle), std::sin(angle), 0}));
  }
  const PointsHull made = hull_of_points(points);
  check_sound(made, points);
  CHECK(made.hull.vertices.size() == 6);
  REQUIRE(made.hull.faces.size() == 2);
  CHECK_THAT(made.hull.faces[0].normal, IsNear(-made.hull.faces[1].normal, 1e-12));
}

TEST_CASE("hull of points: slivers and bodies of almost no thickness are sound", "[convex]") {
  std::mt19937_64 engine(2);
  std::uniform_real_distribution<double> uniform(-kSize / 2, kSize / 2);
  const double thickness = GENERATE(1e-3, 1e-6, 1e-7, 3e-8, 1e-8, 1e-9, 1e-12, 1e-15);
  const Quat q = from_rotation_vector({0.3, -0.8, 0.4});
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Vec3> points;
    for (int i = 0; i < 40; ++i) {
      points.push_back(
          rotate(q, Vec3{uniform(engine), uniform(engine), thickness * uniform(engine)}));
    }
    CAPTURE(thickness, trial);
    check_sound(hull_of_points(points), points);
  }
}

TEST_CASE("hull of points: what has no area is refused", "[convex]") {
  const std::vector<Vec3> line{{0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}};
  CHECK_THROWS_WITH(hull_of_points(line), Contains("on a line"));
  const std::vector<Vec3> point(4, Vec3{1, 2, 3});
  CHECK_THROWS_WITH(hull_of_points(point), Contains("on a line"));
  const std::vector<Vec3> two{{0, 0, 0}, {1, 1, 1}};
  CHECK_THROWS_WITH(hull_of_points(two), Contains("three points"));
  const std::vector<Vec3> broken{{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 0}};
  CHECK_THROWS_WITH(hull_of_points(broken), Contains("not finite"));
}

TEST_CASE("hull: the support vertex is the farthest, from any start", "[convex]") {
  std::mt19937_64 engine(3);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i) points.push_back(kSize * random_direction(engine));
  for (const Vec3& p : cube_points({})) points.push_back(1.3 * p);
  const PointsHull made = hull_of_points(points);
  const Hull hull = made.hull.view();
  for (uint32_t trial = 0; trial < 2000; ++trial) {
    const Vec3 way = random_direction(engine);
    double farthest = -std::numeric_limits<double>::infinity();
    for (const Vec3& p : hull.vertices) farthest = std::max(farthest, dot(way, p));
    const auto n = static_cast<uint32_t>(hull.vertices.size());
    CHECK(dot(way, hull.vertices[support_vertex(hull, way, trial % n)]) == farthest);
  }
}

TEST_CASE("hull: each defect is named", "[convex]") {
  const PointsHull made = hull_of_points(cube_points({}));
  const auto defect = [&](auto&& spoil) {
    HullData hull = made.hull;
    spoil(hull);
    const char* found = hull_defect(hull.view(), kTolerance);
    return std::string(found == nullptr ? "" : found);
  };
  CHECK(defect([](HullData&) {}) == "");
  CHECK_THAT(defect([](HullData& h) { h.edges[3].next = 99; }), Contains("out of range"));
  CHECK_THAT(defect([](HullData& h) { h.edge_from.pop_back(); }), Contains("each vertex"));
  CHECK_THAT(defect([](HullData& h) { std::swap(h.edges[0].twin, h.edges[1].twin); }),
             Contains("twins"));
  CHECK_THAT(defect([](HullData& h) { std::swap(h.edge_from[0], h.edge_from[1]); }),
             Contains("leaves another"));
  CHECK_THAT(defect([](HullData& h) { h.faces[2].normal = -h.faces[2].normal; }),
             Contains("not in its plane"));
  CHECK_THAT(defect([](HullData& h) { h.faces[2].normal *= 2; }), Contains("unit"));
  CHECK_THAT(defect([](HullData& h) { h.faces[2].offset += kSize / 100; }),
             Contains("not in its plane"));
  CHECK_THAT(defect([](HullData& h) { h.faces[2].offset -= kSize / 100; }), Contains("beyond"));
  CHECK_THAT(defect([](HullData& h) { h.edge_from.push_back(0), h.vertices.push_back({}); }),
             Contains("is not 2"));
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/point/point_proxy.cpp, near_features.cpp and query/plane_extent.cpp.
#include "contact/detect/point/point_proxy.h"

#include <random>

#include "contact/bake/inside.h"
#include "contact/detect/point/near_features.h"
#include "contact/query/triangle/plane_extent.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kEpsilon = 1e-7;
constexpr double kStandOff = 2e-7;  // the proxy keeps epsilon off each surface

PointProxy proxy_at(const TestScene& s, const Vec3& p_W) {
  PointProxy proxy;
  REQUIRE(seed_proxy(s.scene, p_W, proxy) == 0);
  REQUIRE(proxy.seeded);
  return proxy;
}

Vec3 random_vec(std::mt19937_64& rng, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(rng), uniform(rng), uniform(rng)};
}

}  // namespace

TEST_CASE("point proxy: in free space it is the tool", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  PointProxy proxy = proxy_at(s, {0, 0, 0.1});
  const ProxyMove move = move_proxy(s.scene, {0.02, 0.01, 0.06}, proxy);
  CHECK(proxy.g_W == Vec3{0.02, 0.01, 0.06});
  CHECK(move.n_active == 0);
  CHECK(move.free_fraction == 1);
}

TEST_CASE("point proxy: on a face it is the projection of the tool", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  PointProxy proxy = proxy_at(s, {0, 0, 0.1});
  const ProxyMove move = move_proxy(s.scene, {0.02, 0.01, 0.03}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0.02, 0.01, 0.05}, kStandOff));
  CHECK(proxy.g_W.z > 0.05);
  CHECK(move.n_active == 1);
}

TEST_CASE("point proxy: 90 degree concave corner", "[contact][trap]") {
  // the inside of a room with walls x ≥ 0 and y ≥ 0, the tool 1 and 2 mm behind them
  TestScene s;
  s.add(haptic::test::turned_inside_out(haptic::make_box({0.2, 0.2, 0.2})), {{0.1, 0.1, 0}, {}});
  PointProxy proxy = proxy_at(s, {0.01, 0.01, 3e-3});
  const ProxyMove move = move_proxy(s.scene, {-1e-3, -2e-3, 3e-3}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0, 0, 3e-3}, kStandOff));
  CHECK(proxy.g_W.x > 0);
  CHECK(proxy.g_W.y > 0);
  CHECK(move.n_active == 2);
}

TEST_CASE("point proxy: three walls meet in a vertex", "[contact]") {
  TestScene s;
  s.add(haptic::test::turned_inside_out(haptic::make_box({0.2, 0.2, 0.2})), {{0.1, 0.1, 0.1}, {}});
  PointProxy proxy = proxy_at(s, {0.01, 0.02, 0.03});
  const ProxyMove move = move_proxy(s.scene, {-3e-3, -1e-3, -2e-3}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0, 0, 0}, kStandOff));
  CHECK(move.n_active == 3);
}

TEST_CASE("point proxy: over-constraint trap", "[contact][trap]") {
  // a floor, and a ramp that the tool also violates but that does not push
  TestScene s;
  haptic::Soup soup;
  soup.vertices = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
  soup.triangles = {{0, 2, 1}, {0, 3, 2}};
  s.add(soup);
  const Vec3 n{0.6, 0.8, 0}, along{0.8, -0.6, 0};
  haptic::Soup ramp;
  ramp.vertices = {-1.0 * along + Vec3{0, 0, -1}, along + Vec3{0, 0, -1}, along + Vec3{0, 0, 1},
                   -1.0 * along + Vec3{0, 0, 1}};
  ramp.triangles = {{0, 2, 1}, {0, 3, 2}};
  REQUIRE(dot(cross(ramp.vertices[2] - ramp.vertices[0], ramp.vertices[1] - ramp.vertices[0]), n) >
          0);
  s.add(ramp);
  PointProxy proxy = proxy_at(s, {0.1, 0.5, 0});
  const ProxyMove move = move_proxy(s.scene, {0.1, -1, 0}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0.1, 0, 0}, kStandOff));
  CHECK(move.n_active == 1);
}

TEST_CASE("point proxy: prism of dependent normals", "[contact][trap]") {
  // a V groove with a third plane through its edge: the three normals lie in one plane
  TestScene s;
  const double slope = std::sqrt(0.75);
  for (const Vec3& n : {Vec3{0, 1, 0}, Vec3{slope, 0.5, 0}, Vec3{-slope, 0.5, 0}}) {
    const Vec3 along = cross(n, {0, 0, 1});
    haptic::Soup soup;
    soup.vertices = {-1.0 * along + Vec3{0, 0, -1}, along + Vec3{0, 0, -1}, along + Vec3{0, 0, 1},
                     -1.0 * along + Vec3{0, 0, 1}};
    soup.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (dot(cross(soup.vertices[1] - soup.vertices[0], soup.vertices[2] - soup.vertices[0]), n) <
        0) {
      soup = haptic::test::turned_inside_out(soup);
    }
    s.add(soup);
  }
  PointProxy proxy = proxy_at(s, {0.01, 0.4, 0});
  move_proxy(s.scene, {0.05, -1, 0.2}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0, 0, 0.2}, 3 * kStandOff));
}

TEST_CASE("point proxy: acute wedge is swept again after each solve", "[contact][trap]") {
  // walls 10 degrees apart, tool far behind the apex: without the second sweep it would tunnel
  TestScene s;
  const double half_angle = 5 * 3.14159265358979323846 / 180;
  for (const double side : {1.0, -1.0}) {
    const Vec3 along{std::cos(half_angle), side * std::sin(half_angle), 0};
    const Vec3 n{std::sin(half_angle), -side * std::cos(half_angle), 0};
    haptic::Soup soup;
    soup.vertices = {Vec3{0, 0, -1}, along + Vec3{0, 0, -1}, along + Vec3{0, 0, 1}, Vec3{0, 0, 1}};
    soup.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (dot(cross(soup.vertices[1] - soup.vertices[0], soup.vertices[2] - soup.vertices[0]), n) <
        0) {
      soup = haptic::test::turned_inside_out(soup);
    }
    s.add(soup);
  }
  std::mt19937_64 rng(3);
  for (int trial = 0; trial < 2000; ++trial) {
    PointProxy proxy = proxy_at(s, {0.9, 0, 0});
    for (int k = 0; k < 5; ++k) {
      move_proxy(s.scene, Vec3{-0.3, 0, 0} + random_vec(rng, 0.3), proxy);
      REQUIRE(proxy.g_W.x > 0);
      REQUIRE(std::fabs(proxy.g_W.y) < proxy.g_W.x * std::tan(half_angle));
    }
  }
}

TEST_CASE("point proxy: thin plate is never passed in 1e5 random ticks", "[contact][trap]") {
  // a plate of 0.1 mm, the tool up to 50 mm behind it
  TestScene s;
  s.add(haptic::make_box({1, 1, 1e-4}));
  std::mt19937_64 rng(5);
  PointProxy proxy = proxy_at(s, {0, 0, 0.01});
  for (int k = 0; k < 100000; ++k) {
    Vec3 tool = random_vec(rng, 0.05);
    tool.z = k % 3 == 0 ? tool.z : -std::fabs(tool.z);
    move_proxy(s.scene, tool, proxy);
    REQUIRE(proxy.g_W.z > 0.5e-4);
  }
}

TEST_CASE("point proxy: random walk on a sphere and a notched block never gets inside",
          "[contact][property]") {
  const bool notched = GENERATE(false, true);
  TestScene s;
  if (notched) {
    // an L-shaped prism: convex and concave edges
    haptic::Soup soup;
    const std::vector<Vec3> outline{{0, 0, 0},       {0.04, 0, 0},    {0.04, 0.02, 0},
                                    {0.02, 0.02, 0}, {0.02, 0.04, 0}, {0, 0.04, 0}};
    soup = haptic::test::make_prism(outline, 0.02);
    s.add(soup, {{-0.015, -0.015, 0}, {}});
  } else {
    s.add(haptic::make_icosphere(0.03, 3));
  }
  const haptic::InsideOracle oracle(s.shapes[0].mesh);
  std::mt19937_64 rng(11);
  PointProxy proxy = proxy_at(s, {0.05, 0.05, 0.05});
  Vec3 tool{0.05, 0.05, 0.05};
  for (int k = 0; k < 20000; ++k) {
    tool = 0.98 * tool + random_vec(rng, 0.01);
    const double before = norm(tool - proxy.g_W);
    const ProxyMove move = move_proxy(s.scene, tool, proxy);
    CAPTURE(k, notched, tool.x, tool.y, tool.z);
    REQUIRE((move.flags & haptic::kContactIterationLimit) == 0);
    REQUIRE_FALSE(oracle.inside(inverse(s.scene.X_WO[0]) * proxy.g_W));
    // every update reduces the distance to the tool, which proves convergence
    REQUIRE(norm(tool - proxy.g_W) <= before + tol(kEpsilon));
  }
}

TEST_CASE("point proxy: segments through shared edges and vertices do not slip in", "[contact]") {
  TestScene s;
  s.add(haptic::make_icosphere(0.03, 2));
  const haptic::InsideOracle oracle(s.shapes[0].mesh);
  for (const Vec3& v : s.shapes[0].mesh.vertices) {
    for (const haptic::Triangle& t :
         {s.shapes[0].mesh.triangles[0], s.shapes[0].mesh.triangles[7]}) {
      const Vec3 mid = 0.5 * (v + s.shapes[0].mesh.vertices[t[0]]);
      PointProxy proxy = proxy_at(s, 2.0 * v);
      move_proxy(s.scene, Vec3{}, proxy);
      REQUIRE_FALSE(oracle.inside(proxy.g_W));
      move_proxy(s.scene, mid, proxy);
      REQUIRE_FALSE(oracle.inside(proxy.g_W));
    }
  }
}

TEST_CASE("point proxy: an object that runs into the proxy carries it along", "[contact][trap]") {
  // a thin plate at 1 m/s: 1 mm per step, ten times its thickness
  TestScene s;
  s.add(haptic::make_box({0.2, 0.2, 1e-4}));
  s.scene.X_WO[0].p.z = -0.02;
  PointProxy proxy = proxy_at(s, {0, 0, 0});
  for (int k = 0; k < 60; ++k) {
    s.scene.X_WO[0].p.z += 1e-3;
    move_proxy(s.scene, {0, 0, 0}, proxy);
    REQUIRE(proxy.g_W.z > s.scene.X_WO[0].p.z + 0.5e-4);
  }
  CHECK_THAT(proxy.g_W, IsNear({0, 0, s.scene.X_WO[0].p.z + 0.5e-4}, kStandOff));
}

TEST_CASE("point proxy: a proxy crushed between two objects is reported", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}), {{0, 0, -0.06}, {}});
  s.add(haptic::make_box({0.1, 0.1, 0.1}), {{0, 0, 0.06}, {}});
  PointProxy proxy = proxy_at(s, {0, 0, 0});
  uint32_t flags = 0;
  for (int k = 0; k < 30; ++k) {
    s.scene.X_WO[0].p.z += 1e-3;
    flags |= move_proxy(s.scene, {0, 0, 0}, proxy).flags;
  }
  CHECK((flags & haptic::kContactNoFreePose) != 0);
}

TEST_CASE("point proxy: what carries it must not push it into another moving object", "[contact]") {
  // the block below rises, the one above moves sideways, in either order in the scene
  const bool below_first = GENERATE(true, false);
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}), {{0, 0, below_first ? -0.0505 : 0.0505}, {}});
  s.add(haptic::make_box({0.1, 0.1, 0.1}), {{0, 0, below_first ? 0.0505 : -0.0505}, {}});
  PointProxy proxy = proxy_at(s, {0, 0, 0});
  const size_t below = below_first ? 0 : 1;
  s.scene.X_WO[below].p.z += 1.2e-3;
  s.scene.X_WO[1 - below].p.x += 1e-3;
  CHECK((move_proxy(s.scene, {0, 0, 0}, proxy).flags & haptic::kContactNoFreePose) != 0);
}

TEST_CASE("point proxy: a start inside is moved to the nearest surface and reported", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  PointProxy proxy;
  CHECK(seed_proxy(s.scene, {0.01, 0, 0.04}, proxy) == haptic::kContactReseeded);
  CHECK(proxy.seeded);
  CHECK_THAT(proxy.g_W, IsNear({0.01, 0, 0.05}, kStandOff));
  CHECK(proxy.g_W.z > 0.05);
}

TEST_CASE("point proxy: the answer does not depend on where the world's origin is",
          "[contact][property]") {
  std::mt19937_64 rng(17);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose X{random_vec(rng, 0.5), haptic::from_rotation_vector(random_vec(rng, 2))};
    TestScene a, b;
    a.add(haptic::make_icosphere(0.03, 2));
    b.add(haptic::make_icosphere(0.03, 2), X);
    PointProxy proxy_a = proxy_at(a, {0, 0, 0.05}), proxy_b = proxy_at(b, X * Vec3{0, 0, 0.05});
    for (int k = 0; k < 20; ++k) {
      const Vec3 tool = random_vec(rng, 0.03);
      move_proxy(a.scene, tool, proxy_a);
      move_proxy(b.scene, X * tool, proxy_b);
      REQUIRE_THAT(proxy_b.g_W, IsNear(X * proxy_a.g_W, 1e-9));
    }
  }
}

TEST_CASE("near features: above a box face only that face is near", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  auto scratch = std::make_unique<haptic::NearScratch>();
  std::array<haptic::NearFeature, 16> out;
  const auto near = near_features(s.shapes[0], {0.03, 0.02, 0.051}, 0.05, *scratch, out);
  REQUIRE(near.count == 1);
  CHECK(out[0].closest.feature.kind == haptic::FeatureKind::kFace);
  CHECK_THAT(out[0].normal_O, IsNear({0, 0, 1}, 1e-12));
}

TEST_CASE("near features: beyond a convex edge the edge is near, with the normal to the point",
          "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  auto scratch = std::make_unique<haptic::NearScratch>();
  std::array<haptic::NearFeature, 16> out;
  auto near = near_features(s.shapes[0], {0.053, 0.01, 0.054}, 0.02, *scratch, out);
  REQUIRE(near.count == 1);
  CHECK(out[0].closest.feature.kind == haptic::FeatureKind::kEdge);
  CHECK_THAT(out[0].normal_O, IsNear({0.6, 0, 0.8}, 1e-9));
  near = near_features(s.shapes[0], {0.06, 0.06, 0.06}, 0.03, *scratch, out);
  REQUIRE(near.count == 1);
  CHECK(out[0].closest.feature.kind == haptic::FeatureKind::kVertex);
}

TEST_CASE("near features: in a concave corner both walls are near", "[contact]") {
  TestScene s;
  s.add(haptic::test::turned_inside_out(haptic::make_box({0.2, 0.2, 0.2})));
  auto scratch = std::make_unique<haptic::NearScratch>();
  std::array<haptic::NearFeature, 16> out;
  const auto near = near_features(s.shapes[0], {0.097, 0.096, 0.01}, 0.01, *scratch, out);
  REQUIRE(near.count == 2);
  CHECK_THAT(out[0].normal_O, IsNear({-1, 0, 0}, 1e-12));
  CHECK_THAT(out[1].normal_O, IsNear({0, -1, 0}, 1e-12));
}

TEST_CASE("plane extent: on a box face it is the distance to the nearest edge", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.02, 0.03, 0.1}));
  const auto& mesh = s.shapes[0].mesh;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.face_normals[t].z < 0.5) continue;
    CHECK(plane_extent(mesh, t, {0.004, 0.002, 0.05}) == Approx(0.006));
    CHECK(plane_extent(mesh, t, {0.01, 0, 0.05}) == haptic::kMinExtent);
  }
}

TEST_CASE("plane extent: concave edges do not limit a plane", "[contact]") {
  TestScene s;
  s.add(haptic::test::turned_inside_out(haptic::make_box({0.02, 0.03, 0.1})));
  CHECK(plane_extent(s.shapes[0].mesh, 0,
                     s.shapes[0].mesh.vertices[s.shapes[0].mesh.triangles[0][0]]) ==
        haptic::kMaxExtent);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/point/point_proxy.cpp, of a point and of a sphere, and for
// query/plane_extent.cpp.
#include "contact/detect/point/point_proxy.h"

#include <algorithm>

#include "contact/bake/inside.h"
#include "contact/query/triangle/plane_extent.h"
#include "tests/proto/math/half_spaces.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kFar = 1e9;
constexpr double kStandOff = 2e-7;  // the proxy keeps epsilon off each surface

PointProxy proxy_at(const TestScene& s, const Vec3& p_W) {
  PointProxy proxy;
  REQUIRE(seed_proxy(s.scene, p_W, proxy) == 0);
  REQUIRE(proxy.seeded);
  return proxy;
}

/// Distance from the proxy's centre to the nearest surface of the scene.
double clearance(const TestScene& s, const PointProxy& proxy) {
  double least = kFar;
  for (size_t i = 0; i < s.shapes.size(); ++i) {
    const Vec3 g_O = inverse(s.scene.X_WO[i]) * proxy.g_W;
    least = std::min(least, closest_point(s.shapes[i], g_O, kFar).distance);
  }
  return least;
}

/// A triangle large enough to act as a plane near the origin.
void add_plane(Soup& soup, const Vec3& n, double offset, double size) {
  const Vec3 u = any_perpendicular(n), v = cross(n, u);
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  for (const double angle : {0.3, 0.3 + 2.0943951, 0.3 + 4.1887902}) {
    soup.vertices.push_back(offset * n + size * (std::cos(angle) * u + std::sin(angle) * v));
  }
  soup.triangles.push_back({first, first + 1, first + 2});
}

/// Planes through the origin, an object each.
TestScene scene_of(const std::vector<Vec3>& normals, double radius) {
  TestScene s;
  for (const Vec3& n : normals) {
    Soup soup;
    add_plane(soup, n, 0, 3);
    s.add(soup);
  }
  s.scene.radius = radius;
  return s;
}

TestScene scene_of(const Soup& soup, double radius, const Pose& X_WO = {}) {
  TestScene s;
  s.add(soup, X_WO);
  s.scene.radius = radius;
  return s;
}

/// An L-shaped prism with convex and concave edges, a ball, and a crumpled ball, which has edges
/// and vertices of both kinds.
TestScene explored_scene(int kind, double radius, Random& random) {
  if (kind == 0) {
    const std::vector<Vec3> notched{{0, 0, 0},       {0.04, 0, 0},    {0.04, 0.02, 0},
                                    {0.02, 0.02, 0}, {0.02, 0.04, 0}, {0, 0.04, 0}};
    return scene_of(make_prism(notched, 0.02), radius, {{-0.015, -0.015, 0}, {}});
  }
  Soup ball = make_icosphere(0.03, 3);
  if (kind == 2) {
    for (Vec3& v : ball.vertices) v *= 1 + 0.05 * random.uniform(-1, 1);
  }
  return scene_of(ball, radius);
}

}  // namespace

TEST_CASE("point proxy: in free space it is the tool", "[contact]") {
  const TestScene s = scene_of(make_box({0.1, 0.1, 0.1}), 0);
  PointProxy proxy = proxy_at(s, {0, 0, 0.1});
  const ProxyMove move = move_proxy(s.scene, {0.02, 0.01, 0.06}, proxy);
  CHECK(proxy.g_W == Vec3{0.02, 0.01, 0.06});
  CHECK(move.n_active == 0);
  CHECK(move.free_fraction == 1);
}

TEST_CASE("point proxy: on a face it is the projection of the tool", "[contact]") {
  const double radius = GENERATE(0.0, 5e-3);
  const TestScene s = scene_of(make_box({0.1, 0.1, 0.1}), radius);
  PointProxy proxy = proxy_at(s, {0, 0, 0.1});
  const ProxyMove move = move_proxy(s.scene, {0.02, 0.01, 0.03}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0.02, 0.01, 0.05 + radius}, kStandOff));
  CHECK(proxy.g_W.z > 0.05 + radius);
  CHECK(move.n_active == 1);
}

TEST_CASE("point proxy: 90 degree concave corner", "[contact][trap]") {
  // the inside of a room with three walls at zero, the tool behind two of them and behind all
  const double r = GENERATE(0.0, 2e-3), rounding = r > 0 ? 1e-7 : 0;
  const TestScene s =
      scene_of(turned_inside_out(make_box({0.2, 0.2, 0.2})), r, {{0.1, 0.1, 0.1}, {}});
  PointProxy proxy = proxy_at(s, {0.01, 0.02, 0.03});
  ProxyMove move = move_proxy(s.scene, {-1e-3, -2e-3, 0.03}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({r, r, 0.03}, kStandOff + rounding));
  CHECK(std::min(proxy.g_W.x, proxy.g_W.y) > r);
  CHECK(move.n_active == 2);
  move = move_proxy(s.scene, {-3e-3, -1e-3, -2e-3}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({r, r, r}, kStandOff + 2 * rounding));
  CHECK(move.n_active == 3);
}

TEST_CASE("sphere proxy: it rolls around a convex edge and a vertex", "[contact]") {
  // next to the edge x = z = 50 mm, nearer than the radius: pushed straight away from it
  const TestScene s = scene_of(make_box({0.1, 0.1, 0.1}), 5e-3);
  PointProxy proxy = proxy_at(s, {0.07, 0, 0.08});
  const Vec3 tool{0.0503, 0.001, 0.0504};
  for (int k = 0; k < 5; ++k) move_proxy(s.scene, tool, proxy);
  const double room = s.scene.radius + s.scene.epsilon;
  CHECK_THAT(proxy.g_W, IsNear(Vec3{0.05, 0.001, 0.05} + room * Vec3{0.6, 0, 0.8}, 1e-6));
  proxy = proxy_at(s, {0.07, 0.07, 0.07});
  for (int k = 0; k < 5; ++k) move_proxy(s.scene, {0.0504, 0.0504, 0.0504}, proxy);
  CHECK_THAT(proxy.g_W,
             IsNear(Vec3{0.05, 0.05, 0.05} + (room / std::sqrt(3.0)) * Vec3{1, 1, 1}, 1e-6));
}

TEST_CASE("point proxy: over-constraint trap", "[contact][trap]") {
  // a floor, and a ramp that the tool also violates but that does not push
  const double radius = GENERATE(0.0, 0.01);
  const TestScene s = scene_of({{0, 1, 0}, {0.6, 0.8, 0}}, radius);
  PointProxy proxy = proxy_at(s, {0.1, 0.5, 0});
  const ProxyMove move = move_proxy(s.scene, {0.1, -1, 0}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0.1, radius, 0}, kStandOff));
  CHECK(move.n_active == 1);
}

TEST_CASE("point proxy: prism of dependent normals", "[contact][trap]") {
  // a V groove with a third plane through its edge: the three normals lie in one plane; two ramps
  // lift a sphere above the floor, each a radius away
  const double radius = GENERATE(0.0, 0.01), slope = std::sqrt(0.75);
  const TestScene s = scene_of({{0, 1, 0}, {slope, 0.5, 0}, {-slope, 0.5, 0}}, radius);
  PointProxy proxy = proxy_at(s, {0.01, 0.4, 0});
  move_proxy(s.scene, {0.05, -1, 0.2}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0, 2 * radius, 0.2}, radius > 0 ? 1e-6 : 3 * kStandOff));
}

TEST_CASE("point proxy: acute wedge is swept again after each solve", "[contact][trap]") {
  // walls 10 degrees apart, tool far behind the apex: without the second sweep it would tunnel
  const double half_angle = 5 * 3.14159265358979323846 / 180;
  const double across = std::cos(half_angle), ahead = std::sin(half_angle);
  const TestScene s = scene_of({{ahead, -across, 0}, {ahead, across, 0}}, 0);
  Random random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    PointProxy proxy = proxy_at(s, {0.9, 0, 0});
    for (int k = 0; k < 5; ++k) {
      move_proxy(s.scene, random.in_box({-0.6, -0.3, -0.3}, {0, 0.3, 0.3}), proxy);
      REQUIRE(proxy.g_W.x > 0);
      REQUIRE(std::fabs(proxy.g_W.y) < proxy.g_W.x * std::tan(half_angle));
    }
  }
}

TEST_CASE("sphere proxy: random convex soups against the exact QP", "[contact][property]") {
  // the free side of n_i·x ≥ d_i is convex: the proxy solves the QP of the planes offset by r
  const double radius = GENERATE(0.0, 1e-3, 5e-3);
  Random random(23);
  for (size_t trial = 0; trial < trials(150); ++trial) {
    Soup soup;
    std::vector<HalfSpace> h;
    const size_t n = 4 + random.index(9);
    for (size_t i = 0; i < n; ++i) {
      const Vec3 normal = random.direction();
      const double offset = -random.uniform(0.02, 0.1);
      add_plane(soup, normal, offset, 5);
      h.push_back({normal, offset + radius});
    }
    TestScene s = scene_of(soup, radius);
    s.scene.epsilon = 1e-9;
    PointProxy proxy = proxy_at(s, {});
    for (int k = 0; k < 4; ++k) {
      const Vec3 tool = random.in_box({-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2});
      move_proxy(s.scene, tool, proxy);
      const Vec3 exact = nearest_by_enumeration(h, tool);
      CAPTURE(trial, k, radius, n, tool, proxy.g_W, exact);
      REQUIRE(clearance(s, proxy) >= radius);
      REQUIRE(norm(proxy.g_W - exact) <= tol(1e-6) * norm(tool));
    }
  }
}

TEST_CASE("point proxy: thin plate is never passed in 1e5 random ticks", "[contact][trap]") {
  // a plate of 0.1 mm, the tool up to 50 mm behind it
  const double radius = GENERATE(0.0, 5e-5);
  const TestScene s = scene_of(make_box({1, 1, 1e-4}), radius);
  Random random(5);
  PointProxy proxy = proxy_at(s, {0, 0, 0.01});
  for (size_t k = 0; k < trials(100000); ++k) {
    Vec3 tool = random.in_box({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
    if (k % 3 != 0) tool.z = -std::fabs(tool.z);
    move_proxy(s.scene, tool, proxy);
    REQUIRE(proxy.g_W.z > 0.5e-4 + radius);
  }
}

TEST_CASE("sphere proxy: on a random walk it never comes nearer than its radius, and never jams",
          "[contact][property]") {
  const double radius = GENERATE(0.0, 0.2e-3, 1e-3, 5e-3);
  const int kind = GENERATE(0, 1, 2);
  Random random(31);
  const TestScene s = explored_scene(kind, radius, random);
  const InsideOracle oracle(s.shapes[0].mesh);
  PointProxy proxy = proxy_at(s, {0.05, 0.05, 0.05});
  Vec3 tool{0.05, 0.05, 0.05};
  size_t limits = 0, pressed = 0;
  const size_t n = trials(radius == 0 ? 20000 : 4000);
  for (size_t k = 0; k < n; ++k) {
    tool = 0.98 * tool + random.in_box({-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01});
    const double before = norm(tool - proxy.g_W);
    const ProxyMove move = move_proxy(s.scene, tool, proxy);
    CAPTURE(k, kind, radius, tool, proxy.g_W);
    limits += (move.flags & kContactIterationLimit) != 0;
    pressed += move.n_active > 0;
    REQUIRE_FALSE(oracle.inside(inverse(s.scene.X_WO[0]) * proxy.g_W));
    REQUIRE(clearance(s, proxy) >= radius - tol(1e-15));
    // every update reduces the distance to the tool, which proves convergence
    REQUIRE(norm(tool - proxy.g_W) <= before + tol(1e-7));
    // no jam: at rest, no free place around it is nearer to the tool
    if ((move.flags & kContactIterationLimit) != 0 || k % 10 != 0) continue;
    for (int i = 0; i < 20; ++i) {
      const Vec3 aside = proxy.g_W + 20e-6 * random.direction();
      const double gain = norm(tool - proxy.g_W) - norm(tool - aside);
      if (gain < 2e-6) continue;
      PointProxy there{aside, true, proxy.X_WO};
      if (oracle.inside(inverse(s.scene.X_WO[0]) * aside)) continue;
      REQUIRE(clearance(s, there) < radius + 1e-6);
    }
  }
  CAPTURE(kind, radius, limits, pressed);
  CHECK(pressed > n / 10);
  CHECK(limits <= (radius == 0 && kind < 2 ? 0 : n / 50));
}

TEST_CASE("point proxy: an object that runs into the proxy carries it along", "[contact][trap]") {
  // a thin plate at 1 m/s: 1 mm per step, ten times its thickness; later it turns as well
  const double radius = GENERATE(0.0, 1e-3), x = GENERATE(0.0, 0.03);
  TestScene s = scene_of(make_box({0.2, 0.2, 1e-4}), radius, {{0, 0, -0.02}, {}});
  PointProxy proxy = proxy_at(s, {x, 0, 0});
  for (int k = 0; k < 60; ++k) {
    s.scene.X_WO[0].p.z += 1e-3;
    if (k > 20 && x > 0) s.scene.X_WO[0].q = from_rotation_vector({0, -0.01 * (k - 20), 0});
    const ProxyMove move = move_proxy(s.scene, {x, 0, 0}, proxy);
    CAPTURE(k, proxy.g_W);
    REQUIRE((move.flags & kContactNoFreePose) == 0);
    const Vec3 g_O = inverse(s.scene.X_WO[0]) * proxy.g_W;
    REQUIRE(g_O.z > radius + 0.5e-4);
    if (k > 20) REQUIRE(g_O.z <= radius + 0.5e-4 + (x > 0 ? 1e-6 : kStandOff));
    if (x == 0) REQUIRE(std::hypot(g_O.x, g_O.y) <= kStandOff);
  }
}

TEST_CASE("point proxy: a proxy crushed between two objects is reported", "[contact]") {
  TestScene s = scene_of(make_box({0.1, 0.1, 0.1}), 0, {{0, 0, -0.06}, {}});
  s.add(make_box({0.1, 0.1, 0.1}), {{0, 0, 0.06}, {}});
  PointProxy proxy = proxy_at(s, {0, 0, 0});
  uint32_t flags = 0;
  for (int k = 0; k < 30; ++k) {
    s.scene.X_WO[0].p.z += 1e-3;
    flags |= move_proxy(s.scene, {0, 0, 0}, proxy).flags;
  }
  CHECK((flags & kContactNoFreePose) != 0);
}

TEST_CASE("point proxy: what carries it must not push it into another moving object", "[contact]") {
  // the block below rises, the one above moves sideways, in either order in the scene
  const size_t below = GENERATE(0u, 1u);
  const double first = below == 0 ? -0.0505 : 0.0505;
  TestScene s = scene_of(make_box({0.1, 0.1, 0.1}), 0, {{0, 0, first}, {}});
  s.add(make_box({0.1, 0.1, 0.1}), {{0, 0, -first}, {}});
  PointProxy proxy = proxy_at(s, {0, 0, 0});
  s.scene.X_WO[below].p.z += 1.2e-3;
  s.scene.X_WO[1 - below].p.x += 1e-3;
  CHECK((move_proxy(s.scene, {0, 0, 0}, proxy).flags & kContactNoFreePose) != 0);
}

TEST_CASE("point proxy: a start inside is moved to the nearest surface and reported", "[contact]") {
  // a sphere may also be too near
  const auto [radius, z] =
      GENERATE(table<double, double>({{0, 0.04}, {5e-3, 0.04}, {5e-3, 0.052}}));
  const TestScene s = scene_of(make_box({0.1, 0.1, 0.1}), radius);
  PointProxy proxy;
  CHECK(seed_proxy(s.scene, {0.01, 0, z}, proxy) == kContactReseeded);
  CHECK(proxy.seeded);
  CHECK_THAT(proxy.g_W, IsNear({0.01, 0, 0.05 + radius}, kStandOff));
  CHECK(proxy.g_W.z > 0.05);
  CHECK(clearance(s, proxy) >= radius);
}

TEST_CASE("point proxy: the answer does not depend on where the world's origin is",
          "[contact][property]") {
  Random random(17);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose X = random.pose(0.5);
    const TestScene a = scene_of(make_icosphere(0.03, 2), 0),
                    b = scene_of(make_icosphere(0.03, 2), 0, X);
    PointProxy proxy_a = proxy_at(a, {0, 0, 0.05}), proxy_b = proxy_at(b, X * Vec3{0, 0, 0.05});
    for (int k = 0; k < 20; ++k) {
      const Vec3 tool = random.in_box({-0.03, -0.03, -0.03}, {0.03, 0.03, 0.03});
      move_proxy(a.scene, tool, proxy_a);
      move_proxy(b.scene, X * tool, proxy_b);
      REQUIRE_THAT(proxy_b.g_W, IsNear(X * proxy_a.g_W, 1e-9));
    }
  }
}

TEST_CASE("plane extent: on a box face it is the distance to the nearest edge", "[contact]") {
  const MeshShapeData box = build_shape(make_box({0.02, 0.03, 0.1}));
  const TriangleMesh mesh = box.view().mesh;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.face_normals[t].z < 0.5) continue;
    CHECK(plane_extent(mesh, t, {0.004, 0.002, 0.05}) == Approx(0.006));
    CHECK(plane_extent(mesh, t, {0.01, 0, 0.05}) == kMinExtent);
  }
  // concave edges do not limit a plane
  const MeshShapeData room = build_shape(turned_inside_out(make_box({0.02, 0.03, 0.1})));
  const TriangleMesh walls = room.view().mesh;
  CHECK(plane_extent(walls, 0, walls.vertices[walls.triangles[0][0]]) == kMaxExtent);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/point/point_proxy.cpp with a radius: the virtual proxy's configuration
// space.
#include <algorithm>

#include "contact/bake/inside.h"
#include "contact/detect/point/point_proxy.h"
#include "proto/math/project_point.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kFar = 1e9;

PointProxy proxy_at(const TestScene& s, const Vec3& p_W) {
  PointProxy proxy;
  REQUIRE(seed_proxy(s.scene, p_W, proxy) == 0);
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
void add_plane(haptic::Soup& soup, const Vec3& n, double offset, double size) {
  const Vec3 u = any_perpendicular(n), v = cross(n, u);
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  for (const double angle : {0.3, 0.3 + 2.0943951, 0.3 + 4.1887902}) {
    soup.vertices.push_back(offset * n + size * (std::cos(angle) * u + std::sin(angle) * v));
  }
  soup.triangles.push_back({first, first + 1, first + 2});
}

/// Nearest point to p with n_i·x ≥ d_i by trying every set of at most three planes.
Vec3 nearest_by_enumeration(const std::vector<haptic::HalfSpace>& h, const Vec3& p) {
  Vec3 best;
  double best_distance = kFar;
  const auto offer = [&](const Vec3& x) {
    for (const auto& plane : h) {
      if (dot(plane.normal, x) < plane.offset - 1e-10) return;
    }
    if (norm(x - p) < best_distance) best = x, best_distance = norm(x - p);
  };
  offer(p);
  for (size_t i = 0; i < h.size(); ++i) {
    offer(p + (h[i].offset - dot(h[i].normal, p)) * h[i].normal);
    for (size_t j = i + 1; j < h.size(); ++j) {
      // on the line of two planes: from the point of it nearest to the origin
      const Vec3 &a = h[i].normal, &b = h[j].normal;
      const Vec3 along = cross(a, b);
      const double sine2 = norm_squared(along);
      if (sine2 < 1e-8) continue;
      const Vec3 on_line = cross(h[i].offset * b - h[j].offset * a, along) / sine2;
      offer(on_line + (dot(p - on_line, along) / sine2) * along);
      for (size_t k = j + 1; k < h.size(); ++k) {
        const Vec3& c = h[k].normal;
        const double volume = dot(a, cross(b, c));
        if (std::fabs(volume) < 1e-6) continue;
        offer((h[i].offset * cross(b, c) + h[j].offset * cross(c, a) + h[k].offset * cross(a, b)) /
              volume);
      }
    }
  }
  return best;
}

}  // namespace

TEST_CASE("sphere proxy: on a face its centre is a radius away", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  s.scene.radius = 5e-3;
  PointProxy proxy = proxy_at(s, {0, 0, 0.1});
  const ProxyMove move = move_proxy(s.scene, {0.02, 0.01, 0.03}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0.02, 0.01, 0.055}, 2e-7));
  CHECK(proxy.g_W.z >= 0.055);
  CHECK(move.n_active == 1);
}

TEST_CASE("sphere proxy: 90 degree concave corner and three walls", "[contact][trap]") {
  TestScene s;
  s.add(haptic::test::turned_inside_out(haptic::make_box({0.2, 0.2, 0.2})), {{0.1, 0.1, 0.1}, {}});
  s.scene.radius = 2e-3;
  PointProxy proxy = proxy_at(s, {0.01, 0.02, 0.03});
  ProxyMove move = move_proxy(s.scene, {-1e-3, -2e-3, 0.03}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({2e-3, 2e-3, 0.03}, 3e-7));
  CHECK(move.n_active == 2);
  move = move_proxy(s.scene, {-3e-3, -1e-3, -2e-3}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({2e-3, 2e-3, 2e-3}, 4e-7));
  CHECK(move.n_active == 3);
}

TEST_CASE("sphere proxy: it rolls around a convex edge and a vertex", "[contact]") {
  // next to the edge x = z = 50 mm, nearer than the radius: pushed straight away from it
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  s.scene.radius = 5e-3;
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

TEST_CASE("sphere proxy: over-constraint trap", "[contact][trap]") {
  TestScene s;
  haptic::Soup floor, ramp;
  add_plane(floor, {0, 1, 0}, 0, 3);
  add_plane(ramp, {0.6, 0.8, 0}, 0, 3);
  s.add(floor);
  s.add(ramp);
  s.scene.radius = 0.01;
  PointProxy proxy = proxy_at(s, {0.1, 0.5, 0});
  const ProxyMove move = move_proxy(s.scene, {0.1, -1, 0}, proxy);
  CHECK_THAT(proxy.g_W, IsNear({0.1, 0.01, 0}, 2e-7));
  CHECK(move.n_active == 1);
}

TEST_CASE("sphere proxy: prism of linearly dependent normals", "[contact][trap]") {
  TestScene s;
  const double slope = std::sqrt(0.75);
  for (const Vec3& n : {Vec3{0, 1, 0}, Vec3{slope, 0.5, 0}, Vec3{-slope, 0.5, 0}}) {
    haptic::Soup soup;
    add_plane(soup, n, 0, 3);
    s.add(soup);
  }
  s.scene.radius = 0.01;
  PointProxy proxy = proxy_at(s, {0.01, 0.4, 0});
  move_proxy(s.scene, {0.05, -1, 0.2}, proxy);
  // two ramps lift it above the floor: each a radius away
  CHECK_THAT(proxy.g_W, IsNear({0, 0.02, 0.2}, 1e-6));
}

TEST_CASE("sphere proxy: random convex soups against the exact QP", "[contact][property]") {
  // the free side of n_i·x ≥ d_i is convex: the proxy solves the QP of the planes offset by r
  const double radius = GENERATE(0.0, 1e-3, 5e-3);
  Random random(23);
  for (size_t trial = 0; trial < trials(150); ++trial) {
    haptic::Soup soup;
    std::vector<haptic::HalfSpace> h;
    const size_t n = 4 + random.index(9);
    for (size_t i = 0; i < n; ++i) {
      const Vec3 normal = random.direction();
      const double offset = -random.uniform(0.02, 0.1);
      add_plane(soup, normal, offset, 5);
      h.push_back({normal, offset + radius});
    }
    TestScene s;
    s.add(soup);
    s.scene.radius = radius;
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

TEST_CASE("sphere proxy: thin plate w = 0.1 mm, r = 0.05 mm, 1e5 random ticks", "[contact][trap]") {
  TestScene s;
  s.add(haptic::make_box({1, 1, 1e-4}));
  s.scene.radius = 5e-5;
  Random random(5);
  PointProxy proxy = proxy_at(s, {0, 0, 0.01});
  for (size_t k = 0; k < trials(100000); ++k) {
    Vec3 tool = random.in_box({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
    if (k % 3 != 0) tool.z = -std::fabs(tool.z);
    move_proxy(s.scene, tool, proxy);
    REQUIRE(proxy.g_W.z >= 1e-4);
  }
}

TEST_CASE("sphere proxy: on a random walk it never comes nearer than its radius, and never jams",
          "[contact][property]") {
  const double radius = GENERATE(0.0, 0.2e-3, 1e-3, 5e-3);
  const int kind = GENERATE(0, 1, 2);
  TestScene s;
  Random random(31);
  if (kind == 0) {
    const std::vector<Vec3> notched{{0, 0, 0},       {0.04, 0, 0},    {0.04, 0.02, 0},
                                    {0.02, 0.02, 0}, {0.02, 0.04, 0}, {0, 0.04, 0}};
    s.add(haptic::test::make_prism(notched, 0.02), {{-0.015, -0.015, 0}, {}});
  } else if (kind == 1) {
    s.add(haptic::make_icosphere(0.03, 3));
  } else {
    // a crumpled ball: edges and vertices of both kinds
    haptic::Soup ball = haptic::make_icosphere(0.03, 3);
    for (Vec3& v : ball.vertices) v *= 1 + 0.05 * random.uniform(-1, 1);
    s.add(ball);
  }
  s.scene.radius = radius;
  const haptic::InsideOracle oracle(s.shapes[0].mesh);
  PointProxy proxy = proxy_at(s, {0.05, 0.05, 0.05});
  Vec3 tool{0.05, 0.05, 0.05};
  size_t limits = 0, pressed = 0;
  const size_t n = trials(4000);
  for (size_t k = 0; k < n; ++k) {
    tool = 0.98 * tool + random.in_box({-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01});
    const double before = norm(tool - proxy.g_W);
    const ProxyMove move = move_proxy(s.scene, tool, proxy);
    CAPTURE(k, kind, radius, tool, proxy.g_W);
    limits += (move.flags & haptic::kContactIterationLimit) != 0;
    pressed += move.n_active > 0;
    REQUIRE_FALSE(oracle.inside(inverse(s.scene.X_WO[0]) * proxy.g_W));
    REQUIRE(clearance(s, proxy) >= radius - tol(1e-15));
    REQUIRE(norm(tool - proxy.g_W) <= before + tol(1e-7));
    // no jam: at rest, no free place around it is nearer to the tool
    if ((move.flags & haptic::kContactIterationLimit) != 0 || k % 10 != 0) continue;
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
  CHECK(limits <= n / 50);
}

TEST_CASE("sphere proxy: an object that runs into it carries it along, turning too",
          "[contact][trap]") {
  TestScene s;
  s.add(haptic::make_box({0.2, 0.2, 1e-4}));
  s.scene.X_WO[0].p.z = -0.02;
  s.scene.radius = 1e-3;
  PointProxy proxy = proxy_at(s, {0.03, 0, 0});
  for (int k = 0; k < 60; ++k) {
    s.scene.X_WO[0].p.z += 1e-3;
    if (k > 20) s.scene.X_WO[0].q = haptic::from_rotation_vector({0, -0.01 * (k - 20), 0});
    const ProxyMove move = move_proxy(s.scene, {0.03, 0, 0}, proxy);
    CAPTURE(k, proxy.g_W);
    REQUIRE((move.flags & haptic::kContactNoFreePose) == 0);
    const Vec3 g_O = inverse(s.scene.X_WO[0]) * proxy.g_W;
    REQUIRE(g_O.z >= 1e-3 + 0.5e-4);
    if (k > 20) REQUIRE(g_O.z <= 1e-3 + 0.5e-4 + 1e-6);
  }
}

TEST_CASE("sphere proxy: a start too near or inside is moved to where there is room", "[contact]") {
  TestScene s;
  s.add(haptic::make_box({0.1, 0.1, 0.1}));
  s.scene.radius = 5e-3;
  PointProxy proxy;
  CHECK(seed_proxy(s.scene, {0.01, 0, 0.052}, proxy) == haptic::kContactReseeded);
  CHECK_THAT(proxy.g_W, IsNear({0.01, 0, 0.055}, 2e-7));
  CHECK(seed_proxy(s.scene, {0.01, 0, 0.04}, proxy) == haptic::kContactReseeded);
  CHECK_THAT(proxy.g_W, IsNear({0.01, 0, 0.055}, 2e-7));
  CHECK(clearance(s, proxy) >= s.scene.radius);
}

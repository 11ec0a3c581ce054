// SPDX-License-Identifier: GPL-3.0-or-later
// Directions from a vertex, and a point at rest on one, against brute force over directions.
#include "contact/query/triangle/vertex_fan.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/meshes.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr uint32_t kFirst = 1;  // vertex of the rim; 0 is the apex
constexpr int kTurns = 240, kTilts = 120;
// angle between two tested directions [rad]
constexpr double kGrid = 2 * std::numbers::pi / kTurns;

/// Facets around the origin with random heights, seen from +z.
Soup make_fan(Random& random) {
  const auto n = static_cast<uint32_t>(5 + random.index(5));
  Soup soup;
  soup.vertices = {{0, 0, 0}};
  for (uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + random.uniform(0, 0.5)) / n;
    const double height = random.uniform(-0.05, 0.15);
    soup.vertices.push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle), height});
    soup.triangles.push_back({0, kFirst + i, kFirst + (i + 1) % n});
  }
  return soup;
}

/// Height of the fan over (x, y), by the two coordinates in the facet below.
double height_over(const Soup& fan, double x, double y) {
  for (const Triangle& t : fan.triangles) {
    const Vec3 &p = fan.vertices[t[1]], &q = fan.vertices[t[2]];
    const double area = p.x * q.y - p.y * q.x;
    const double a = (x * q.y - y * q.x) / area, b = (p.x * y - p.y * x) / area;
    if (a >= 0 && b >= 0) return a * p.z + b * q.z;
  }
  return 0;
}

/// Largest goal · d over unit directions above the fan; at least zero, because it may stay.
double furthest_above(const Soup& fan, const Vec3& goal) {
  double best = 0;
  for (int i = 0; i < kTurns; ++i) {
    const double c = std::cos(kGrid * i), s = std::sin(kGrid * i);
    const double slope = height_over(fan, c, s);
    for (int k = 0; k < kTilts; ++k) {
      const double tilt = std::numbers::pi * (k + 0.5) / kTilts - std::numbers::pi / 2;
      if (std::tan(tilt) < slope) continue;
      const Vec3 d{std::cos(tilt) * c, std::cos(tilt) * s, std::sin(tilt)};
      best = std::max(best, dot(goal, d));
    }
  }
  return best;
}

/// A goal that is not visible from the apex.
Vec3 hidden_goal(Random& random, const Soup& fan) {
  for (;;) {
    const Vec3 goal = 0.02 * random.direction();
    if (goal.z < height_over(fan, goal.x, goal.y)) return goal;
  }
}

}  // namespace

TEST_CASE("vertex fan: the steepest way is that of all directions above it", "[contact]") {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Soup soup = make_fan(random);
    const MeshShapeData shape = build_shape(soup);
    const auto triangle = static_cast<uint32_t>(random.index(soup.triangles.size()));
    const VertexFan fan(shape.view().mesh, triangle, 0);
    CHECK(fan.places() == 2 * soup.triangles.size());
    const Vec3 goal = hidden_goal(random, soup);
    const WayFromVertex way = fan.steepest(goal);
    CAPTURE(trial);
    CHECK(way.reach == Approx(furthest_above(soup, goal)).margin(tol(kGrid * norm(goal))));
    CHECK(way.found == (way.reach > 0));
    if (way.found) CHECK(dot(goal, way.direction_O) == Approx(way.reach));
  }
}

TEST_CASE("vertex fan: all of it beside a border too", "[contact]") {
  Random random(2);
  Soup soup = make_fan(random);
  soup.triangles.pop_back();
  const MeshShapeData shape = build_shape(soup);
  for (uint32_t t = 0; t < soup.triangles.size(); ++t) {
    CHECK(VertexFan(shape.view().mesh, t, 0).places() == 2 * soup.triangles.size());
  }
}

TEST_CASE("point proxy: at rest at a vertex where no direction leads nearer", "[contact][trap]") {
  Random random(3);
  int at_apex = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Soup soup = make_fan(random);
    TestScene s;
    s.add(soup);
    s.scene.epsilon = 1e-10;
    PointProxy proxy;
    Vec3 start = 0.002 * random.direction();
    start.z = height_over(soup, start.x, start.y) + 1e-3;
    REQUIRE(seed_proxy(s.scene, start, proxy) == 0);
    const Vec3 tool = hidden_goal(random, soup);
    const ProxyMove move = move_proxy(s.scene, tool, proxy);
    CAPTURE(trial);
    CHECK((move.flags & kContactIterationLimit) == 0);
    CHECK(proxy.g_W.z > height_over(soup, proxy.g_W.x, proxy.g_W.y));
    if (norm(proxy.g_W) > 1e-6) continue;
    ++at_apex;
    CHECK(furthest_above(soup, tool) <= tol(kGrid * norm(tool)));
  }
  CHECK(at_apex > 20);
}

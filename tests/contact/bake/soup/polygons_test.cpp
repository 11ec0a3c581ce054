// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/soup/polygons.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "contact/bake/bake.h"
#include "tests/support/mesh_files.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

/// A point of the plane with integer coordinates, so that the oracle's arithmetic is exact.
struct Grid2 {
  int64_t x, y;
  bool operator==(const Grid2&) const = default;
};

/// Twice the signed area of a triangle.
int64_t turn(const Grid2& a, const Grid2& b, const Grid2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

int sign(int64_t x) {
  return (x > 0) - (x < 0);
}

bool on_segment(const Grid2& a, const Grid2& b, const Grid2& p) {
  return turn(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}

bool meet(const Grid2& a, const Grid2& b, const Grid2& c, const Grid2& d) {
  if (sign(turn(a, b, c)) * sign(turn(a, b, d)) < 0 &&
      sign(turn(c, d, a)) * sign(turn(c, d, b)) < 0)
    return true;
  return on_segment(a, b, c) || on_segment(a, b, d) || on_segment(c, d, a) || on_segment(c, d, b);
}

/// By definition: sides meet only if they are consecutive, and then only at the corner.
bool is_simple(const std::vector<Grid2>& polygon) {
  const size_t n = polygon.size();
  for (size_t i = 0; i < n; ++i) {
    const Grid2 &a = polygon[i], &b = polygon[(i + 1) % n], &c = polygon[(i + 2) % n];
    if (a == b || on_segment(a, b, c) || on_segment(b, c, a)) return false;
    for (size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n == i) continue;
      if (meet(a, b, polygon[j], polygon[(j + 1) % n])) return false;
    }
  }
  return true;
}

int64_t twice_area(const std::vector<Grid2>& polygon) {
  int64_t sum = 0;
  for (size_t i = 2; i < polygon.size(); ++i) sum += turn(polygon[0], polygon[i - 1], polygon[i]);
  return sum;
}

bool is_flat(const std::vector<Grid2>& polygon) {
  for (const Grid2& b : polygon)
    for (const Grid2& c : polygon)
      if (turn(polygon[0], b, c) != 0) return false;
  return true;
}

/// On a plane through the origin, tilted such that the last axis stays the normal's largest.
std::vector<Vec3> lifted(const std::vector<Grid2>& polygon) {
  std::vector<Vec3> corners;
  for (const Grid2& p : polygon) {
    const auto x = static_cast<double>(p.x), y = static_cast<double>(p.y);
    corners.push_back({x, y, 0.25 * x - 0.5 * y});
  }
  return corners;
}

using Side = std::pair<uint32_t, uint32_t>;

/// Per edge, the number of uses in one direction minus those in the other.
std::map<Side, int> border(const std::vector<Triangle>& triangles) {
  std::map<Side, int> sides;
  for (const Triangle& t : triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = t[i], b = t[(i + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  std::erase_if(sides, [](const auto& side) { return side.second == 0; });
  return sides;
}

std::map<Side, int> border_of_polygon(uint32_t n) {
  std::map<Side, int> sides;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t next = (i + 1) % n;
    sides[{std::min(i, next), std::max(i, next)}] = i < next ? 1 : -1;
  }
  return sides;
}

}  // namespace

TEST_CASE("bake polygons: random polygons are cut into their area, or refused as not simple") {
  std::mt19937_64 random(41);
  size_t simple = 0, refused = 0;
  for (size_t round = 0; round < sweep(20'000); ++round) {
    const size_t n = 4 + random() % 5;
    // few places, so that corners fall on sides and on each other
    const uint64_t span = round % 2 == 0 ? 5 : 1000;
    std::vector<Grid2> polygon;
    while (polygon.size() < n) {
      polygon.push_back(
          {static_cast<int64_t>(random() % span), static_cast<int64_t>(random() % span)});
    }
    if (is_flat(polygon)) continue;
    const auto cut = cut_polygon(lifted(polygon));
    CAPTURE(round, n);
    REQUIRE(cut.has_value() == is_simple(polygon));
    refused += !cut;
    if (!cut) continue;
    ++simple;
    REQUIRE(cut->size() == n - 2);
    CHECK(border(*cut) == border_of_polygon(static_cast<uint32_t>(n)));
    const int64_t area = twice_area(polygon);
    int64_t sum = 0;
    bool turns_alike = true;
    for (const auto& [a, b, c] : *cut) {
      const int64_t part = turn(polygon[a], polygon[b], polygon[c]);
      turns_alike = turns_alike && sign(part) == sign(area);
      sum += part;
    }
    CHECK(turns_alike);
    CHECK(sum == area);
  }
  CHECK(simple > sweep(20'000) / 20);
  CHECK(refused > sweep(20'000) / 20);
}

TEST_CASE("bake polygons: where corners begin and which way they turn does not change the cut") {
  std::mt19937_64 random(43);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto as_sets = [](const std::vector<Triangle>& triangles, size_t first, size_t step,
                          size_t n) {
    std::vector<std::array<size_t, 3>> sets;
    for (const Triangle& t : triangles) {
      std::array<size_t, 3> set{};
      for (size_t i = 0; i < 3; ++i) set[i] = (first + t[i] * step) % n;
      std::sort(set.begin(), set.end());
      sets.push_back(set);
    }
    std::sort(sets.begin(), sets.end());
    return sets;
  };
  for (size_t round = 0; round < sweep(500); ++round) {
    // round and wavy, not planar
    const size_t n = 4 + random() % 20;
    std::vector<Vec3> corners;
    for (size_t i = 0; i < n; ++i) {
      const double angle = 6.28 * static_cast<double>(i) / static_cast<double>(n);
      corners.push_back({std::cos(angle), std::sin(angle), 0.3 * u(random)});
    }
    const auto whole = cut_polygon(corners);
    REQUIRE(whole.has_value());
    for (const size_t step : {size_t{1}, n - 1}) {
      const size_t first = random() % n;
      std::vector<Vec3> other;
      for (size_t i = 0; i < n; ++i) other.push_back(corners[(first + i * step) % n]);
      const auto cut = cut_polygon(other);
      REQUIRE(cut.has_value());
      CHECK(as_sets(*cut, first, step, n) == as_sets(*whole, 0, 1, n));
      CHECK(border(*cut) == border_of_polygon(static_cast<uint32_t>(n)));
    }
  }
}

TEST_CASE("bake polygons: of any size and in any place, and many corners take little time") {
  const std::vector<Vec3> arrow{{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}};
  for (const double scale : {1e-300, 1e-160, 1e-3, 1e160, 1e300}) {
    CAPTURE(scale);
    std::vector<Vec3> scaled;
    for (const Vec3& p : arrow) scaled.push_back(scale * p);
    const auto cut = cut_polygon(scaled);
    REQUIRE(cut.has_value());
    CHECK(border(*cut) == border_of_polygon(4));
  }
  // a star of a hundred thousand corners
  std::vector<Vec3> star;
  const size_t n = trials(100'000);
  for (size_t i = 0; i < n; ++i) {
    const double angle = 6.283185 * static_cast<double>(i) / static_cast<double>(n);
    const double radius = i % 2 == 0 ? 1 : 0.5;
    star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  const auto cut = cut_polygon(star);
  REQUIRE(cut.has_value());
  CHECK(cut->size() == n - 2);
}

TEST_CASE("bake polygons: corners on one line are a fan, double corners are no matter") {
  CHECK(cut_polygon(std::vector<Vec3>{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}, {2, 2, 2}})->size() == 2);
  PolygonSoup soup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}},
                   {{0, 4, 1, 2, 2, 3, 0}}};
  CHECK_NOTHROW(check_polygons(soup, "thing"));
  // the third face is a bow tie and repeats one of its corners
  soup.polygons = {{0, 1, 2, 3}, {0, 1, 2}, {0, 0, 2, 1, 3}};
  CHECK_THROWS_WITH(
      check_polygons(soup, "thing.obj"),
      Contains("thing.obj: face 3, of 5 corners") && Contains("triangulate on export"));
}

TEST_CASE(
    "bake polygons: one that is not planar is cut, one that crosses itself refused by number") {
  ObjectConfig object;
  object.unit = 1;
  assign(object.mesh, "thing.obj");
  // a pyramid whose base of five corners is non-planar and has a notch
  const BakedShape baked = bake_contents(
      "v 0 0 0\nv 4 0 0.5\nv 4 4 0\nv 2 1 0.3\nv 0 4 0.2\nv 2 0.5 5\n"
      "f 5 4 3 2 1\nf 1 2 6\nf 2 3 6\nf 3 4 6\nf 4 5 6\nf 5 1 6\n",
      object, kPlenty);
  CHECK(baked.shape.mesh.closed);
  CHECK(baked.shape.mesh.triangles.size() == 8);
  CHECK(baked.report.lines.empty());
  CHECK_THROWS_WITH(
      bake_contents("v 0 0 0\nv 1 1 0\nv 1 0 1\nv 0 1 0\nv 2 2 1\nf 1 2 3 4 5\n", object, kPlenty),
      Contains("thing.obj: face 1, of 5 corners") && Contains("triangulate on export"));
}

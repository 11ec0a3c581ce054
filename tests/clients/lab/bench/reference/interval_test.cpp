// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/interval.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// An interval of any size, sometimes a single number or zero.
Interval random_interval(Random& random) {
  const auto number = [&] {
    const double size = std::exp2(random.uniform(-60, 60));
    return random.index(20) == 0 ? 0.0 : random.uniform(-1, 1) * size;
  };
  const double a = number(), b = random.index(10) == 0 ? a : number();
  return {std::min(a, b), std::max(a, b)};
}

/// One end or a number in between.
double pick(Random& random, const Interval& from) {
  const size_t which = random.index(4);
  if (which == 0) return from.lo;
  if (which == 1) return from.hi;
  return std::clamp(from.lo + random.uniform(0, 1) * (from.hi - from.lo), from.lo, from.hi);
}

bool holds(const Interval3& box, const Vec3& p) {
  return box.x.contains(p.x) && box.y.contains(p.y) && box.z.contains(p.z);
}

bool holds(const Interval& a, long double exact) {
  return static_cast<long double>(a.lo) <= exact && exact <= static_cast<long double>(a.hi);
}

}  // namespace

TEST_CASE("interval: every operation holds what exact arithmetic gives", "[contact][trap]") {
  Random random(1);
  for (size_t k = 0; k < trials(200000); ++k) {
    const Interval a = random_interval(random), b = random_interval(random);
    const double x = pick(random, a), y = pick(random, b);
    const long double lx = x, ly = y;
    CAPTURE(a.lo, a.hi, b.lo, b.hi, x, y);
    REQUIRE(holds(a + b, lx + ly));
    REQUIRE(holds(a - b, lx - ly));
    REQUIRE(holds(a * b, lx * ly));
    REQUIRE(holds(squared(a), lx * lx));
    REQUIRE(holds(magnitude(a), std::fabs(lx)));
    REQUIRE(holds(-a, -lx));
    REQUIRE((hull(a, b).contains(x) && hull(a, b).contains(y)));
  }
}

TEST_CASE("interval: sine and cosine hold every angle in it", "[contact][trap]") {
  Random random(2);
  for (size_t k = 0; k < trials(200000); ++k) {
    const double from = random.uniform(-20, 20) * (k % 7 == 0 ? 1e4 : 1);
    const double width = std::exp2(random.uniform(-40, 3));
    const Interval angle{from, from + width};
    const long double x = pick(random, angle);
    CAPTURE(angle.lo, angle.hi, static_cast<double>(x));
    REQUIRE(holds(sin(angle), std::sin(x)));
    REQUIRE(holds(cos(angle), std::cos(x)));
  }
}

TEST_CASE("interval: sine and cosine are as tight as the ends and the peaks between", "[contact]") {
  const double pi = std::numbers::pi;
  CHECK(cos(Interval{-0.1, 0.2}).hi == 1);
  CHECK(cos(Interval{-0.1, 0.2}).lo == Approx(std::cos(0.2)).epsilon(1e-14));
  CHECK(cos(Interval{3, 3.3}).lo == -1);
  CHECK(sin(Interval{1.5, 1.6}).hi == 1);
  CHECK(sin(Interval{0.1, 0.2}).lo == Approx(std::sin(0.1)).epsilon(1e-14));
  CHECK(sin(Interval{0.1, 0.2}).hi == Approx(std::sin(0.2)).epsilon(1e-14));
  CHECK(sin(Interval{-1.6, 1.6}) == Interval{-1, 1});
  CHECK(cos(Interval{0, 2 * pi}) == Interval{-1, 1});
  CHECK(sin(Interval{1e9, 1e9}) == Interval{-1, 1});
  CHECK(cos(Interval{0, std::numeric_limits<double>::infinity()}) == Interval{-1, 1});
}

TEST_CASE("interval: a square is never negative", "[contact][trap]") {
  const Interval square = squared(Interval{-1, 2});
  CHECK(square.lo == 0);
  CHECK(square.hi == Approx(4).epsilon(1e-15));
  CHECK(squared(Interval{1e-200, 1e-190}).lo >= 0);
  CHECK(squared(Interval{-3, -2}).lo == Approx(4).epsilon(1e-15));
}

TEST_CASE("interval: of vectors dot and cross hold what is between", "[contact]") {
  Random random(3);
  for (size_t k = 0; k < trials(20000); ++k) {
    std::array<Interval3, 2> boxes;
    std::array<Vec3, 2> points;
    for (size_t i = 0; i < 2; ++i) {
      boxes[i] = {random_interval(random), random_interval(random), random_interval(random)};
      points[i] = {pick(random, boxes[i].x), pick(random, boxes[i].y), pick(random, boxes[i].z)};
    }
    const auto& [p, q] = points;
    REQUIRE(dot(boxes[0], boxes[1]).contains(dot(p, q)));
    REQUIRE(holds(cross(boxes[0], boxes[1]), cross(p, q)));
    REQUIRE(holds(boxes[0] + boxes[1], p + q));
    REQUIRE(holds(boxes[0] - boxes[1], p - q));
  }
}

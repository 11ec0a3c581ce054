// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/math/project_point.cpp.
#include "proto/math/project_point.h"

#include <limits>
#include <random>
#include <vector>

#include "tests/proto/math/half_spaces.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

Vec3 random_unit(std::mt19937_64& rng) {
  std::normal_distribution<double> gauss;
  return normalized(Vec3{gauss(rng), gauss(rng), gauss(rng)});
}

}  // namespace

TEST_CASE("project: a point outside every plane stays", "[math]") {
  const std::vector<HalfSpace> h{{{0, 0, 1}, 0.0}};
  const PointProjection r = project_onto_half_spaces({1, 2, 3}, h);
  CHECK(r.x == Vec3{1, 2, 3});
  CHECK(r.n_active == 0);
  CHECK(r.converged);
}

TEST_CASE("project: 90 degree concave corner", "[math][trap]") {
  // tool = (−1, −2, 3) mm, planes x ≥ 0 and y ≥ 0, g = (0, 0, 3) mm
  const std::vector<HalfSpace> h{{{1, 0, 0}, 0}, {{0, 1, 0}, 0}};
  const PointProjection r = project_onto_half_spaces({-1e-3, -2e-3, 3e-3}, h);
  CHECK_THAT(r.x, IsNear({0, 0, 3e-3}, 1e-3 * kAlgebra));
  CHECK(r.n_active == 2);
}

TEST_CASE("project: over-constraint trap", "[math][trap]") {
  // the goal violates both planes, but only the first one pushes
  const std::vector<HalfSpace> h{{{0, 1, 0}, 0}, {{0.6, 0.8, 0}, 0}};
  const PointProjection r = project_onto_half_spaces({0.1, -1, 0}, h);
  CHECK_THAT(r.x, IsNear({0.1, 0, 0}, kAlgebra));
  REQUIRE(r.n_active == 1);
  CHECK(r.active[0] == 0);
}

TEST_CASE("project: prism of three dependent normals falls back to two planes", "[math][trap]") {
  // coplanar normals: the 3×3 system is singular
  const double s = std::sqrt(0.75);
  const std::vector<HalfSpace> h{{{0, 1, 0}, -0.1}, {{s, 0.5, 0}, 0}, {{-s, 0.5, 0}, 0}};
  const PointProjection r = project_onto_half_spaces({0.2, -1, 0.7}, h);
  CHECK(r.converged);
  CHECK_THAT(r.x, IsNear({0, 0, 0.7}, kAlgebra));
  CHECK(r.n_active == 2);
}

TEST_CASE("project: the same plane many times is one plane", "[math]") {
  std::vector<HalfSpace> h;
  for (int i = 0; i < 64; ++i) {
    h.push_back({normalized(Vec3{1e-16 * i, 0, 1}), 1e-18 * i});
  }
  const PointProjection r = project_onto_half_spaces({0.3, 0.2, -0.01}, h);
  CHECK(r.converged);
  CHECK_THAT(r.x, IsNear({0.3, 0.2, 0}, kAlgebra));
}

TEST_CASE("project: contradictory planes are reported, not looped over", "[math]") {
  const std::vector<HalfSpace> h{{{0, 0, 1}, 1}, {{0, 0, -1}, 1}};
  const PointProjection r = project_onto_half_spaces({0, 0, 0}, h);
  CHECK_FALSE(r.converged);
  CHECK(is_finite(r.x));
}

TEST_CASE("project: shallow valleys are solved at any depth", "[math][property]") {
  // two nearly equal planes have huge multipliers of opposite effect, which loses digits
  std::mt19937_64 rng(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 20000; ++trial) {
    const Vec3 up = random_unit(rng), across = normalized(cross(up, random_unit(rng)));
    const double half = 0.5 * std::pow(10, -3 + 2 * uniform(rng));  // 0.001 to 0.1 rad, halved
    const Vec3 bottom = 0.05 * random_unit(rng);
    const Vec3 a = std::cos(half) * up + std::sin(half) * across;
    const Vec3 b = std::cos(half) * up - std::sin(half) * across;
    const double depth = 0.01 * uniform(rng);
    const PointProjection r = project_onto_half_spaces(
        bottom - depth * up, std::vector<HalfSpace>{{a, dot(a, bottom)}, {b, dot(b, bottom)}});
    CAPTURE(trial, half, depth);
    REQUIRE(r.converged);
    REQUIRE(r.n_active == 2);
    // the bottom of the valley is ill-conditioned across it, not in height
    REQUIRE(std::fabs(dot(r.x - bottom, up)) <= tol(1e-15) / half);
    REQUIRE(norm(r.x - bottom) <= tol(1e-16) / (half * half) + tol(1e-15));
  }
}

TEST_CASE("project: a plane that is not finite is reported", "[math]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(project_onto_half_spaces({}, std::vector<HalfSpace>{{{0, 0, nan}, 1}}).converged);
  CHECK_FALSE(project_onto_half_spaces({}, std::vector<HalfSpace>{{{0, 0, 1}, 1}, {{0, 1, 0}, nan}})
                  .converged);
}

TEST_CASE("project: random half-spaces agree with brute force and satisfy KKT",
          "[math][property]") {
  std::mt19937_64 rng(20261121);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 3000; ++trial) {
    // a point c that satisfies all planes keeps the problem feasible
    const Vec3 c{uniform(rng), uniform(rng), uniform(rng)};
    const Vec3 p{3 * uniform(rng), 3 * uniform(rng), 3 * uniform(rng)};
    std::vector<HalfSpace> h(static_cast<size_t>(1 + trial % 10));
    for (HalfSpace& s : h) {
      s.normal = random_unit(rng);
      s.offset = dot(s.normal, c) - 0.1 * std::fabs(uniform(rng));
    }
    const PointProjection r = project_onto_half_spaces(p, h);
    CAPTURE(trial, p.x, p.y, p.z, h.size());
    REQUIRE(r.converged);
    CHECK(norm(r.x - nearest_by_enumeration(h, p)) <= tol(1e-7));
    Vec3 push = r.x - p;
    for (int i = 0; i < r.n_active; ++i) {
      const auto k = static_cast<size_t>(i);
      const HalfSpace& s = h[static_cast<size_t>(r.active[k])];
      CHECK(r.multiplier[k] >= 0);
      CHECK(std::fabs(dot(s.normal, r.x) - s.offset) <= tol(1e-9));
      push -= r.multiplier[k] * s.normal;
    }
    CHECK(norm(push) <= tol(1e-9));
    for (const HalfSpace& s : h) CHECK(dot(s.normal, r.x) - s.offset >= -tol(1e-9));
  }
}

TEST_CASE("project: 64 planes of a polytope need few steps", "[math]") {
  std::mt19937_64 rng(7);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<HalfSpace> h(64);
    for (HalfSpace& s : h) s = {random_unit(rng), -1.0};
    const PointProjection r = project_onto_half_spaces(5.0 * random_unit(rng), h);
    CHECK(r.converged);
    CHECK(r.iterations < 32);
    for (const HalfSpace& s : h) CHECK(dot(s.normal, r.x) - s.offset >= -tol(1e-9));
  }
}

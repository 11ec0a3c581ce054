// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/conservative_advancement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

double brute_distance(const MeshShapeData& A, const MeshShapeData& B, const Pose& X_AB) {
  const TriangleMesh mesh_A = A.mesh.view(), mesh_B = B.mesh.view();
  double least = std::numeric_limits<double>::infinity();
  for (uint32_t a = 0; a < mesh_A.triangles.size(); ++a) {
    for (uint32_t b = 0; b < mesh_B.triangles.size(); ++b) {
      least = std::min(
          least, triangle_distance(corners_of(mesh_A, a), corners_of(mesh_B, b, X_AB)).distance);
    }
  }
  return least;
}

}  // namespace

TEST_CASE("conservative advancement: a box that falls flat on a box") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  const Pose from{{0.01, 0, 0.2}, {}}, to{{0.01, 0, 0.05}, {}};
  const Advancement result = advance(box.view(), box.view(), motion_between(from, to, {}));
  CHECK(result.is_hit);
  // 0.1 m of 0.15 m are free
  CHECK(result.time <= 2.0 / 3);
  CHECK(result.time > 2.0 / 3 - 1e-6 / 0.15);
  CHECK(result.nearest.at.distance >= 0.5e-6 * (1 - 1e-6));
  const Advancement back = advance(box.view(), box.view(), motion_between(to, from, {}));
  CHECK(back.is_hit);
  CHECK(back.time == 0);
  const Pose up{{0.01, 0, 0.4}, {}};
  const Advancement free = advance(box.view(), box.view(), motion_between(from, up, {}));
  CHECK_FALSE(free.is_hit);
  CHECK(free.time == 1);
}

TEST_CASE("conservative advancement: the rotating rod that linear interpolation misses") {
  const MeshShapeData rod = build_shape(make_box({1, 0.01, 0.01}));
  const MeshShapeData post = build_shape(make_box({0.01, 0.01, 0.5}));
  // its ends swap places: with linear motion all points would pass through the centre
  const Pose from{{0, -0.4, 0}, {}}, to{{0, -0.4, 0}, from_rotation_vector({0, 0, 3.1})};
  const Advancement result = advance(post.view(), rod.view(), motion_between(from, to, {}));
  REQUIRE(result.is_hit);
  // where the post's near face meets the rod's upper one: about a quarter turn
  CHECK(result.time == Approx((1.5708 - std::asin(0.01 / 0.395)) / 3.1).margin(2e-3));
}

TEST_CASE("conservative advancement: never late against dense sampling, and early by little") {
  Random random(1);
  const MeshShapeData shapes[] = {build_shape(make_box({0.06, 0.04, 0.05})),
                                  build_shape(make_icosphere(0.03, 1)),
                                  build_shape(make_rough_sheet(4, 6, 0.5))};
  size_t n_hits = 0;
  constexpr int kSamples = 40;
  const AdvancementOptions options{.tolerance = 1e-5};
  for (size_t trial = 0; trial < trials(120); ++trial) {
    const MeshShapeData &A = shapes[random.index(3)], &B = shapes[random.index(3)];
    const RigidMotion motion = motion_between(random.pose(0.1), random.pose(0.07),
                                              random.in_box({-0.02, -0.02, -0.02}, {0.02, 0, 0}));
    const Advancement result = advance(A.view(), B.view(), motion, options);
    CAPTURE(trial, result.time);
    REQUIRE_FALSE(result.is_ended);
    const double apart = brute_distance(A, B, motion.at(result.time));
    n_hits += result.is_hit && result.time > 0;
    if (result.is_hit) {
      REQUIRE(apart <= options.tolerance);
    }
    if (result.is_hit && result.time == 0) continue;
    REQUIRE(apart >= (1 - 1e-6) * 0.5 * options.tolerance);
    for (int k = 0; k < kSamples; ++k) {
      const Pose X_AB = motion.at(result.time * k / kSamples);
      REQUIRE(triangle_pairs(A.view(), B.view(), X_AB, {}) == 0);
    }
  }
  CHECK(n_hits > trials(120) / 4);
}

TEST_CASE("conservative advancement: a thin plate at high speed stops it") {
  const MeshShapeData plate = build_shape(make_box({0.2, 0.2, 1e-5}));
  const MeshShapeData ball = build_shape(make_icosphere(0.005, 2));
  Random random(2);
  for (size_t trial = 0; trial < trials(20); ++trial) {
    const Pose from{{0.01, 0.02, 0.05}, random.pose(1).q},
        to{{0.01, 0.02, -0.05}, random.pose(1).q};
    const Advancement result = advance(plate.view(), ball.view(), motion_between(from, to, {}));
    REQUIRE(result.is_hit);
    REQUIRE(result.time == Approx(0.45).margin(0.01));
  }
}

TEST_CASE("conservative advancement: steps that run out and motions that are none are flagged") {
  const MeshShapeData box = build_shape(make_box({0.1, 0.1, 0.1}));
  const Pose from{{0.01, 0, 0.2}, {}}, to{{0.01, 0, 0.05}, from_rotation_vector({1, 0, 0})};
  const RigidMotion motion = motion_between(from, to, {});
  const Advancement whole = advance(box.view(), box.view(), motion);
  const Advancement cut = advance(box.view(), box.view(), motion, {.tolerance = 1e-6, .steps = 3});
  CHECK(cut.is_ended);
  CHECK(cut.steps == 3);
  CHECK_FALSE(cut.is_hit);
  CHECK(cut.time < whole.time);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(advance(box.view(), box.view(), motion_between(from, {{nan, 0, 0}, {}}, {})).is_ended);
  CHECK(advance(box.view(), box.view(), motion, {.tolerance = nan}).is_ended);
  CHECK(advance(build_shape({}).view(), box.view(), motion).time == 1);
  const Advancement still = advance(box.view(), box.view(), motion_between(from, from, {}));
  CHECK(still.time == 1);
  CHECK_FALSE(still.is_hit);
}

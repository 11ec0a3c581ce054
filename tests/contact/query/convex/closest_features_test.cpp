// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/closest_features.h"

#include <algorithm>
#include <cmath>

#include "contact/query/convex/convex_contact.h"
#include "contact/query/convex/expanding_polytope.h"
#include "tests/support/cgal_pairs.h"
#include "tests/support/convex/brute.h"
#include "tests/support/convex/hulls.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::WithinAbs;

namespace {

constexpr double kTolM = 1e-12;  // rounding of a distance of hulls of 20 mm

ConvexPairState random_state(std::mt19937_64& engine, const Hull& a, const Hull& b) {
  ConvexPairState state;
  state.normal_A = random_direction(engine);
  const auto feature = [&](const Hull& hull) -> HullFeature {
    const auto kind = static_cast<HullPart>(engine() % 3);
    const size_t n = kind == HullPart::kVertex ? hull.vertices.size()
                     : kind == HullPart::kEdge ? hull.edges.size()
                                               : hull.faces.size();
    return {kind, static_cast<uint32_t>(engine() % n)};
  };
  state.feature_a = feature(a);
  state.feature_b = feature(b);
  return state;
}

}  // namespace

TEST_CASE("closest features: as near as all pairs of features say, from any start", "[convex]") {
  std::mt19937_64 engine(21);
  std::uniform_real_distribution<double> uniform(0, 1);
  size_t apart = 0;
  for (uint32_t i = 0; i < trials(2000); ++i) {
    const HullData a = random_hull(engine, 4 + i % 40, 0.02);
    const HullData b = i % 7 == 0 ? plate_hull(0.01, 0.004) : random_hull(engine, 4 + i % 23, 0.01);
    const Pose X_AB{0.06 * uniform(engine) * random_direction(engine), random_turn(engine)};
    const Hull hull_a = a.view(), hull_b = b.view();
    const HullPair pair(hull_a, hull_b, X_AB);
    ConvexPairState state;
    if (i % 2 == 0) state = random_state(engine, hull_a, hull_b);
    const ClosestFeatures found = closest_features(pair, state);
    CAPTURE(i);
    CHECK(found.converged);
    // smallest support above zero: they overlap
    const double depth = expand_polytope(pair).depth;
    REQUIRE(found.overlap == (depth > 0));
    if (found.overlap) continue;
    ++apart;
    CHECK_THAT(found.distance, WithinAbs(brute_distance(hull_a, hull_b, X_AB), kTolM));
    CHECK_THAT(found.point_b - found.point_a, IsNear(found.distance * found.normal_A, kTolM));
    CHECK_THAT(norm(found.normal_A), WithinAbs(1, 1e-12));
    // the points are on the hulls
    for (const HullFace& face : a.faces)
      CHECK(dot(face.normal, found.point_a) <= face.offset + 1e-9);
    for (const HullFace& face : b.faces) {
      CHECK(dot(face.normal, inverse(X_AB) * found.point_b) <= face.offset + 1e-9);
    }
  }
  CHECK(apart > trials(2000) / 3);
}

TEST_CASE("closest features: as near as CGAL's exact distance says", "[convex]") {
  std::mt19937_64 engine(22);
  for (size_t i = 0; i < trials(100); ++i) {
    const HullData a = random_hull(engine, 30, 0.02), b = random_hull(engine, 30, 0.02);
    const Pose X_AB{0.05 * random_direction(engine), random_turn(engine)};
    std::vector<Vec3> points_b;
    for (const Vec3& p : b.vertices) points_b.push_back(X_AB * p);
    const Hull hull_a = a.view(), hull_b = b.view();
    ConvexPairState state;
    const double exact = cgal_polytope_distance(a.vertices, points_b);
    const ClosestFeatures found = closest_features(HullPair(hull_a, hull_b, X_AB), state);
    CHECK_THAT(found.distance, WithinAbs(exact, kTolM));
  }
}

TEST_CASE("closest features, trap: a vertex behind the face that was nearest", "[convex]") {
  // far through the hull from where the walk begins: Lin and Canny's walk may stand still here
  const HullData a = box_hull({0.02, 0.02, 0.001}), b = ball_hull(40, 0.002);
  const Hull hull_a = a.view(), hull_b = b.view();
  for (uint32_t f = 0; f < a.faces.size(); ++f) {
    for (const double z : {-0.01, 0.01}) {
      ConvexPairState state;
      state.normal_A = a.faces[f].normal;
      state.feature_a = {HullPart::kFace, f};
      const Pose X_AB{{0.001, 0.002, z}, {}};
      const ClosestFeatures found = closest_features(HullPair(hull_a, hull_b, X_AB), state);
      CHECK_FALSE(found.overlap);
      CHECK_THAT(found.distance, WithinAbs(brute_distance(hull_a, hull_b, X_AB), kTolM));
      CHECK_THAT(found.normal_A, IsNear({0, 0, z > 0 ? 1.0 : -1.0}, 1e-12));
    }
  }
}

TEST_CASE("closest features: coherent queries take a step or two", "[convex]") {
  const HullData a = ball_hull(500, 0.02), b = ball_hull(500, 0.01);
  const Hull hull_a = a.view(), hull_b = b.view();
  ConvexPairState state;
  int n_steps = 0;
  for (int i = 0; i < 1000; ++i) {
    const double t = 1e-3 * i;
    const Pose X_AB{0.035 * normalized(Vec3{std::cos(2 * t), std::sin(2 * t), 0.3 * t}),
                    from_rotation_vector({t, 0.3 * t, 0})};
    const ClosestFeatures found = closest_features(HullPair(hull_a, hull_b, X_AB), state);
    REQUIRE_FALSE(found.overlap);
    if (i > 0) n_steps += found.n_steps;
    if (i % 100 == 0) {
      CHECK_THAT(found.distance, WithinAbs(brute_distance(hull_a, hull_b, X_AB), kTolM));
    }
  }
  CHECK(n_steps <= 2 * 1000);
}

TEST_CASE("convex contact: a pair enters at depth 0, with Kim's predictive depth before",
          "[convex]") {
  std::mt19937_64 engine(23);
  for (size_t trial = 0; trial < trials(30); ++trial) {
    const HullData a = random_hull(engine, 40, 0.02), b = random_hull(engine, 30, 0.015);
    const Hull hull_a = a.view(), hull_b = b.view();
    const Vec3 way = random_direction(engine), spin = random_direction(engine);
    const Quat q = random_turn(engine);
    ConvexPairState state;
    double last = 0;
    bool was_apart = false, was_inside = false;
    for (int i = 0; i < 400; ++i) {
      // in by 4 mm from 1 mm away and back, 25 µm and 0.5 mrad a query
      const double depth = 25e-6 * (200 - std::abs(i - 200));
      const Pose X_AB{(0.034 - depth) * way, from_rotation_vector(5e-4 * i * spin) * q};
      const ConvexContact found = convex_contact(hull_a, hull_b, X_AB, state);
      REQUIRE(found.found);
      const double exact = brute_penetration(hull_a, hull_b, X_AB);
      CAPTURE(trial, i, exact);
      CHECK((found.gap > 0) == (exact < 0));
      if (exact > 0) CHECK(-found.gap >= exact - kTolM);
      CHECK_THAT(dot(found.normal_A, found.point_b - found.point_a), WithinAbs(found.gap, kTolM));
      // distance and depth change by no more than the motion of any point
      if (i > 0) CHECK(std::fabs(found.gap - last) <= 25e-6 + 5e-4 * 0.016 + kTolM);
      last = found.gap;
      was_apart |= found.gap > 0;
      was_inside |= found.gap < 0;
    }
    CHECK((was_apart || was_inside));
  }
}

TEST_CASE("convex contact: what is no pose or no hull gives no contact", "[convex]") {
  const HullData a = box_hull({0.02, 0.02, 0.02});
  const Hull hull = a.view();
  ConvexPairState state;
  CHECK_FALSE(convex_contact(hull, hull, {{std::nan(""), 0, 0}, {}}, state).found);
  CHECK_FALSE(convex_contact(hull, {}, {}, state).found);
  CHECK(convex_contact(hull, hull, {}, state).found);
  // a state of other hulls
  state.feature_a = {HullPart::kEdge, 4000};
  CHECK_THAT(convex_contact(hull, hull, {{0.03, 0, 0}, {}}, state).gap, WithinAbs(-0.01, kTolM));
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/convex/penetration_depth.h"

#include <algorithm>
#include <cmath>

#include "clients/lab/bench/workloads/convex_pairs.h"
#include "contact/query/convex/expanding_polytope.h"
#include "tests/support/convex/brute.h"
#include "tests/support/convex/hulls.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::WithinAbs;

namespace {

constexpr double kDepthTolM = 1e-12;  // rounding of a depth of hulls of 20 mm

PenetrationDepth ask(const HullData& a, const HullData& b, const Pose& X_AB,
                     ConvexPairState state = {}) {
  const Hull hull_a = a.view(), hull_b = b.view();
  return penetration_depth(HullPair(hull_a, hull_b, X_AB), state);
}

/// What must hold of any answer: the points lie on the hulls, their difference is depth · n, and
/// moving b by it parts them.
void check_consistent(const HullData& a, const HullData& b, const Pose& X_AB,
                      const PenetrationDepth& found) {
  const Vec3& n = found.normal_A;
  double reach_a = -1, reach_b = -1;
  for (const Vec3& p : a.vertices) reach_a = std::max(reach_a, dot(n, p) + 1);
  for (const Vec3& p : b.vertices) reach_b = std::max(reach_b, 1 - dot(n, X_AB * p));
  CHECK_THAT(found.depth, WithinAbs(reach_a + reach_b - 2, kDepthTolM));
  CHECK_THAT(norm(n), WithinAbs(1, 1e-12));
  CHECK_THAT(found.point_a - found.point_b, IsNear(found.depth * n, kDepthTolM));
  for (const HullFace& face : a.faces) {
    CHECK(dot(face.normal, found.point_a) <= face.offset + 1e-9);
  }
  for (const HullFace& face : b.faces) {
    CHECK(dot(face.normal, inverse(X_AB) * found.point_b) <= face.offset + 1e-9);
  }
}

struct Share {
  size_t asked = 0, equal = 0, fell_back = 0;
  int n_steps = 0;
};

/// W4 with hulls of n vertices: coherent poses, compared with the polytope in each and with all
/// facets in every `stride`-th.
void follow_coherent(uint32_t n, size_t n_poses, size_t stride, Share& share) {
  const HullData a = hull_of_points(make_convex_points(n, convex_seed_A(n))).hull;
  const HullData b = hull_of_points(make_convex_points(n, convex_seed_B(n))).hull;
  const Hull hull_a = a.view(), hull_b = b.view();
  const std::vector<Pose> poses = make_convex_poses(hull_a, hull_b, n_poses);
  REQUIRE(poses.size() == n_poses);
  ConvexPairState state;
  for (size_t i = 0; i < poses.size(); ++i) {
    const HullPair pair(hull_a, hull_b, poses[i]);
    const PenetrationDepth found = penetration_depth(pair, state);
    const PolytopeDepth polytope = expand_polytope(pair);
    CAPTURE(n, i);
    CHECK(polytope.exact);
    CHECK(found.depth >= polytope.depth - kDepthTolM);
    if (i % stride == 0) {
      const double exact = brute_penetration(hull_a, hull_b, poses[i]);
      CHECK_THAT(polytope.depth, WithinAbs(exact, kDepthTolM));
      CHECK(found.depth >= exact - kDepthTolM);
      check_consistent(a, b, poses[i], found);
    }
    ++share.asked;
    share.equal += found.depth <= polytope.depth + kDepthTolM;
    share.fell_back += found.fell_back;
    share.n_steps += found.n_steps;
  }
}

}  // namespace

TEST_CASE("penetration depth: 10,000 coherent pairs of 20 to 500 vertices", "[convex]") {
  Share share;
  const double scale = torture_scale();
  for (const uint32_t n : kConvexSizes) {
    // all facets take 0.03 ms for 20 vertices, 8.5 ms for 500
    const auto stride = static_cast<size_t>(std::max(1.0, n * n / 2000.0 / scale));
    follow_coherent(n, trials(2000), stride, share);
  }
  CHECK(static_cast<double>(share.equal) >= 0.99 * static_cast<double>(share.asked));
  CHECK(static_cast<double>(share.fell_back) <= 0.005 * static_cast<double>(share.asked) + 5);
  CHECK(static_cast<double>(share.n_steps) <= 4 * static_cast<double>(share.asked));
  UNSCOPED_INFO(share.equal << " of " << share.asked << " equal, " << share.fell_back
                            << " fell back, " << share.n_steps << " steps");
  CHECK(share.asked == 5 * trials(2000));
}

TEST_CASE("penetration depth: a new pair is as deep as all facets say", "[convex]") {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (uint32_t i = 0; i < trials(300); ++i) {
    const HullData a = random_hull(engine, 4 + i % 40, 0.02);
    const HullData b = random_hull(engine, 4 + i % 23, 0.02 * (0.2 + uniform(engine)));
    const Pose X_AB{0.03 * uniform(engine) * random_direction(engine), random_turn(engine)};
    const Hull hull_a = a.view(), hull_b = b.view();
    const double exact = brute_penetration(hull_a, hull_b, X_AB);
    const PolytopeDepth polytope = expand_polytope(HullPair(hull_a, hull_b, X_AB));
    CAPTURE(i, exact);
    CHECK(polytope.exact);
    CHECK((polytope.depth > 0) == (exact > 0));
    if (exact <= 0) continue;
    CHECK_THAT(polytope.depth, WithinAbs(exact, kDepthTolM));
    const PenetrationDepth found = ask(a, b, X_AB);
    CHECK_THAT(found.depth, WithinAbs(exact, kDepthTolM));
    check_consistent(a, b, X_AB, found);
  }
}

TEST_CASE("penetration depth: boxes, min(a_i + b_i - |c_i|)", "[convex]") {
  const Vec3 half_a{0.02, 0.014, 0.01}, half_b{0.006, 0.012, 0.009};
  const HullData a = box_hull(half_a), b = box_hull(half_b);
  std::mt19937_64 engine(12);
  std::uniform_real_distribution<double> uniform(-1, 1);
  ConvexPairState state;
  for (size_t i = 0; i < trials(2000); ++i) {
    const Vec3 c{0.025 * uniform(engine), 0.025 * uniform(engine), 0.018 * uniform(engine)};
    double depth = 1;
    for (int k = 0; k < 3; ++k) depth = std::min(depth, half_a[k] + half_b[k] - std::fabs(c[k]));
    if (depth <= 0) continue;
    CAPTURE(c);
    const PenetrationDepth found = ask(a, b, {c, {}});
    CHECK_THAT(found.depth, WithinAbs(depth, kDepthTolM));
    check_consistent(a, b, {c, {}}, found);
    // the faces touch in a rectangle, whose middle is the point
    const Vec3 way = found.normal_A;
    for (int k = 0; k < 3; ++k) {
      if (std::fabs(way[k]) > 0.5) continue;
      const double low = std::max(-half_a[k], c[k] - half_b[k]);
      const double high = std::min(half_a[k], c[k] + half_b[k]);
      CHECK_THAT(found.point_a[k], WithinAbs((low + high) / 2, 5e-3));
      CHECK(found.point_a[k] >= low - kDepthTolM);
      CHECK(found.point_a[k] <= high + kDepthTolM);
    }
  }
}

TEST_CASE("penetration depth: tessellated balls, 2 - |c| from below", "[convex]") {
  const Pose X_AB{{0.011, 0.006, -0.004}, from_rotation_vector({0.4, 0.1, -0.3})};
  const double exact = 0.02 - norm(X_AB.p);
  double last = 0;
  for (const uint32_t n : {100U, 1000U, 10000U}) {
    const double depth = ask(ball_hull(n, 0.01), ball_hull(n, 0.01), X_AB).depth;
    CAPTURE(n, depth, exact);
    CHECK(depth > last);
    CHECK(depth < exact);
    // the sagitta of a facet is about a quarter of 4 π r² / n over r
    CHECK(exact - depth < 10 * 0.01 / n);
    last = depth;
  }
}

TEST_CASE("penetration depth, trap: local minima", "[convex]") {
  // a thick plate entered from the wrong side: nearer to the other one by 1 mm
  const HullData plate = box_hull({0.02, 0.02, 0.005}), ball = ball_hull(60, 0.002);
  const Hull hull_a = plate.view(), hull_b = ball.view();
  ConvexPairState state;
  const auto at = [&](double z) {
    return penetration_depth(HullPair(hull_a, hull_b, {{1e-3, 2e-3, z}, {}}), state);
  };
  // from above, past the middle: the walk stays where it was, which is deeper than the exact depth
  for (double z = 6e-3; z > -5e-4; z -= 1e-5) {
    const double exact = brute_penetration(hull_a, hull_b, {{1e-3, 2e-3, z}, {}});
    CHECK(at(z).depth >= exact - kDepthTolM);
  }
  // and looks elsewhere before long
  bool fell_back = false;
  for (int i = 0; i < 256; ++i) {
    const PenetrationDepth found = at(-5e-4);
    fell_back |= found.fell_back;
    if (fell_back) CHECK_THAT(found.normal_A, IsNear({0, 0, -1}, 1e-12));
  }
  CHECK(fell_back);
}

TEST_CASE("penetration depth, trap: coplanar faces are one point of the Gauss map", "[convex]") {
  // faces of many corners against each other, at all turns about their common normal
  std::vector<Vec3> prism_points;
  for (int i = 0; i < 24; ++i) {
    const double angle = i * M_PI / 12;
    for (const double z : {-0.01, 0.01}) {
      prism_points.push_back({0.02 * std::cos(angle), 0.02 * std::sin(angle), z});
    }
  }
  const HullData prism = hull_of_points(prism_points).hull;
  for (int i = 0; i < 50; ++i) {
    const Pose X_AB{{0.003, -0.002, 0.0195}, from_rotation_vector({0, 0, i * M_PI / 24})};
    const PenetrationDepth found = ask(prism, prism, X_AB);
    CAPTURE(i);
    CHECK_THAT(found.depth, WithinAbs(0.5e-3, kDepthTolM));
    CHECK(found.feature_a.kind == HullPart::kFace);
    CHECK(found.feature_b.kind == HullPart::kFace);
    CHECK_THAT(found.point_a, IsNear({0.0015, -0.001, 0.01}, 1e-3));
  }
}

TEST_CASE("penetration depth, trap: arcs of 90 degrees and more", "[convex]") {
  // plates without thickness, whose edges turn by 180 degrees, and sharp needles
  const HullData plate = plate_hull(0.02, 0.01);
  const HullData needle =
      hull_of_points(std::vector<Vec3>{
                         {0, 0, 0.03}, {1e-4, 0, -0.01}, {-1e-4, 1e-4, -0.01}, {0, -1e-4, -0.01}})
          .hull;
  std::mt19937_64 engine(13);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (size_t i = 0; i < trials(500); ++i) {
    const HullData& b = i % 2 == 0 ? plate : needle;
    const Pose X_AB{0.008 * uniform(engine) * random_direction(engine), random_turn(engine)};
    const Hull hull_a = plate.view(), hull_b = b.view();
    const PolytopeDepth exact = expand_polytope(HullPair(hull_a, hull_b, X_AB));
    CAPTURE(i, exact.depth);
    REQUIRE(exact.exact);
    if (exact.depth <= 1e-9) continue;
    const PenetrationDepth found = ask(plate, b, X_AB);
    CHECK_THAT(found.depth, WithinAbs(exact.depth, kDepthTolM));
    check_consistent(plate, b, X_AB, found);
  }
  // closed form: a needle's tip through the middle of a plate
  const PenetrationDepth tip = ask(plate, needle, {{0, 0, -0.029}, {}});
  CHECK_THAT(tip.depth, WithinAbs(1e-3, kDepthTolM));
  CHECK_THAT(tip.normal_A, IsNear({0, 0, -1}, 1e-12));
}

TEST_CASE("penetration depth, trap: a virtual feature wins, and is said to", "[convex]") {
  HullData a = box_hull({0.02, 0.02, 0.02});
  const HullData ball = ball_hull(60, 0.005);
  for (HullFace& face : a.faces) face.is_virtual = face.normal.z > 0.5 ? 1 : 0;
  // nearest to the virtual face, then to +x
  const Pose X_AB{{0.012, 0.003, 0.018}, {}};
  const PenetrationDepth found = ask(a, ball, X_AB);
  CHECK_FALSE(found.real);
  CHECK_THAT(found.normal_A, IsNear({0, 0, 1}, 1e-12));
  CHECK(found.feature_a.kind == HullPart::kFace);
  check_consistent(a, ball, X_AB, found);
  // nearest to +x: the same depth as of a box that is real all over
  const Pose aside{{0.018, 0.003, 0.012}, {}};
  CHECK(ask(a, ball, aside).real);
  CHECK_THAT(ask(a, ball, aside).normal_A, IsNear({1, 0, 0}, 1e-12));
}

TEST_CASE("penetration depth, trap: a piece swallowed whole", "[convex]") {
  const HullData big = box_hull({0.03, 0.02, 0.04}), small = box_hull({1e-3, 2e-3, 1e-3});
  const Pose X_AB{{0.005, 0.012, -0.01}, {}};
  const PenetrationDepth inside = ask(big, small, X_AB), around = ask(small, big, inverse(X_AB));
  CHECK_THAT(inside.depth, WithinAbs(0.02 + 2e-3 - 0.012, kDepthTolM));
  CHECK_THAT(inside.normal_A, IsNear({0, 1, 0}, 1e-12));
  CHECK_THAT(around.depth, WithinAbs(inside.depth, kDepthTolM));
  CHECK_THAT(around.normal_A, IsNear({0, -1, 0}, 1e-12));
  // the same centre: no direction between centroids
  CHECK_THAT(ask(big, small, {}).depth, WithinAbs(0.02 + 2e-3, kDepthTolM));
}

TEST_CASE("penetration depth: the same after a rigid motion and with the roles swapped",
          "[convex]") {
  std::mt19937_64 engine(14);
  for (size_t i = 0; i < trials(100); ++i) {
    const HullData a = random_hull(engine, 30, 0.02), b = random_hull(engine, 20, 0.015);
    const Pose X_AB{0.02 * random_direction(engine), random_turn(engine)};
    const PenetrationDepth found = ask(a, b, X_AB), swapped = ask(b, a, inverse(X_AB));
    if (found.depth <= 0) continue;
    CHECK_THAT(swapped.depth, WithinAbs(found.depth, kDepthTolM));
    CHECK_THAT(rotate(X_AB.q, swapped.normal_A), IsNear(-found.normal_A, 1e-9));
  }
}

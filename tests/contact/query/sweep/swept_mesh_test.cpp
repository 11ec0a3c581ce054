// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/query/sweep/swept_mesh.cpp and its parts. Ground truth: closed forms, and exact
// intersection of two meshes at many times (triangle_pairs).
#include "contact/query/sweep/swept_mesh.h"

#include <catch2/catch.hpp>
#include <limits>

#include "contact/query/triangle/closest_on_triangle.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/meshes.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kTolerance = 1e-6;  // [m]

bool meet(const MeshShape& object, const MeshShape& tool, const Pose& X_OT) {
  return triangle_pairs(object, tool, X_OT, {}) > 0;
}

MeshMeeting impact(const MeshShape& object, const MeshShape& tool, const RigidMotion& motion,
                   double tolerance = kTolerance) {
  return SweptMesh(object, tool).time_of_impact(motion, tolerance);
}

double segment_distance(const Vec3& a, const Vec3& b, const Vec3& p) {
  const double length = norm_squared(b - a);
  const double u = length > 0 ? std::clamp(dot(p - a, b - a) / length, 0.0, 1.0) : 0;
  return norm(p - a - u * (b - a));
}

/// Distance of two segments: ends against the other, or the feet of the common perpendicular.
double edge_distance(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  double least = std::min({segment_distance(a, b, c), segment_distance(a, b, d),
                           segment_distance(c, d, a), segment_distance(c, d, b)});
  const Vec3 n = cross(b - a, d - c);
  const double nn = norm_squared(n);
  if (nn == 0) return least;
  const double u = dot(cross(c - a, d - c), n) / nn, v = dot(cross(c - a, b - a), n) / nn;
  if (u > 0 && u < 1 && v > 0 && v < 1) {
    least = std::min(least, std::fabs(dot(c - a, n)) / std::sqrt(nn));
  }
  return least;
}

/// Distance of two disjoint meshes, over all pairs of features.
double distance_of(const MeshShape& object, const MeshShape& tool, const Pose& X_OT) {
  double least = std::numeric_limits<double>::infinity();
  const Pose X_TO = inverse(X_OT);
  for (uint32_t i = 0; i < object.mesh.triangles.size(); ++i) {
    const Corners a = corners_of(object.mesh, i);
    for (uint32_t j = 0; j < tool.mesh.triangles.size(); ++j) {
      const Corners b = corners_of(tool.mesh, j, X_OT);
      for (size_t k = 0; k < 3; ++k) {
        least =
            std::min({least, norm(closest_on_triangle(object.mesh, i, b[k]).point - b[k]),
                      norm(X_OT * closest_on_triangle(tool.mesh, j, X_TO * a[k]).point - a[k])});
        for (size_t l = 0; l < 3; ++l) {
          least = std::min(least, edge_distance(a[k], a[(k + 1) % 3], b[l], b[(l + 1) % 3]));
        }
      }
    }
  }
  return least;
}

RigidMotion random_motion(Random& random, double way, double angle) {
  const Pose from = random.pose(0.012);
  const Pose to{from.p + random.uniform(0, way) * random.direction(),
                from_rotation_vector(random.uniform(0, angle) * random.direction()) * from.q};
  return motion_between(from, to, random.in_box({-4e-3, -4e-3, -4e-3}, {4e-3, 4e-3, 4e-3}));
}

/// A ball and a box, and random motions of the ball that begin apart from the box.
struct BallAndBox {
  explicit BallAndBox(uint32_t subdivisions)
      : ball(build_shape(make_icosphere(5e-3, subdivisions))) {}

  template <typename Use>
  void move(uint64_t seed, size_t n, const Use& use, double way = 15e-3, double angle = 0.5) const {
    Random random(seed);
    for (size_t trial = 0; trial < n; ++trial) {
      const RigidMotion motion = random_motion(random, way, angle);
      if (!meet(box.view(), ball.view(), motion.at(0))) use(motion);
    }
  }
  MeshMeeting hit(const RigidMotion& motion, double tolerance = kTolerance) const {
    return impact(box.view(), ball.view(), motion, tolerance);
  }
  /// Both are within the tolerance, which a slow approach takes long to cross.
  void check_near(const RigidMotion& motion, double time) const {
    CHECK(distance_of(box.view(), ball.view(), motion.at(time)) <= 1.1e-6);
  }

  MeshShapeData ball, box = build_shape(make_box({8e-3, 6e-3, 4e-3}));
};

}  // namespace

TEST_CASE("swept mesh: a box that falls on a box, in closed form", "[contact]") {
  const MeshShapeData box = build_shape(make_box({20e-3, 20e-3, 20e-3}));
  const Quat turned = from_rotation_vector({0, 0, 0.3});
  // 5 mm apart, 20 mm of way
  const RigidMotion falling =
      motion_between({{1e-3, 2e-3, 25e-3}, turned}, {{1e-3, 2e-3, 5e-3}, turned}, {});
  const MeshMeeting hit = impact(box.view(), box.view(), falling);
  REQUIRE(hit.meets);
  CHECK(hit.is_proven);
  CHECK(hit.time <= 0.25);
  CHECK(hit.time >= 0.25 - 1e-6 / 20e-3);
  const RigidMotion beside =
      motion_between({{30e-3, 2e-3, 25e-3}, {}}, {{30e-3, 2e-3, 5e-3}, {}}, {});
  CHECK_FALSE(impact(box.view(), box.view(), beside).meets);
}

TEST_CASE("swept mesh: a plate of 0.01 mm at 10 m/s and 100 Hz is not tunnelled",
          "[contact][trap]") {
  const MeshShapeData plate = build_shape(make_box({60e-3, 60e-3, 0.01e-3}));
  const MeshShapeData ball = build_shape(make_icosphere(5e-3, 2));
  Random random(3);
  for (size_t trial = 0; trial < trials(100); ++trial) {
    // 100 mm in a step, with the plate somewhere within
    const double height = random.uniform(10e-3, 90e-3);
    const Vec3 aside = random.in_box({-20e-3, -20e-3, 0}, {20e-3, 20e-3, 0});
    const Quat q = random.pose(1).q;
    const RigidMotion fast =
        motion_between({aside + Vec3{0, 0, height}, q}, {aside + Vec3{0, 0, height - 0.1}, q}, {});
    const MeshMeeting hit = impact(plate.view(), ball.view(), fast);
    REQUIRE(hit.meets);
    double lowest = 1;
    for (const Vec3& v : ball.mesh.vertices) lowest = std::min(lowest, rotate(q, v).z);
    const double truth = (height + lowest - 0.005e-3) / 0.1;
    CHECK(hit.time <= truth);
    CHECK(hit.time >= truth - 1.1e-6 / 0.1);
  }
}

TEST_CASE("swept mesh: a rod that turns half round meets a post that straight ways miss",
          "[contact][trap]") {
  const MeshShapeData rod = build_shape(make_box({1, 2e-3, 2e-3}));
  const MeshShapeData post = build_shape(make_box({2e-3, 2e-3, 0.2}));
  const Pose first{{0, -0.4, 0}, {}}, last{{0, -0.4, 0}, from_rotation_vector({0, 0, 3.1})};
  CHECK_FALSE(meet(post.view(), rod.view(), first));
  CHECK_FALSE(meet(post.view(), rod.view(), last));
  const MeshMeeting hit = impact(post.view(), rod.view(), motion_between(first, last, {}));
  REQUIRE(hit.meets);
  CHECK(hit.is_proven);
  // the rod's side at distance 1 mm from its axis reaches the near corner of the post at (1, 399)
  const double reach = std::hypot(1e-3, 0.399), towards = std::atan2(0.399, 1e-3);
  const double truth = (towards - std::asin(1e-3 / reach)) / 3.1;
  CHECK(hit.time <= truth);
  CHECK(hit.time >= truth - 1e-5);
}

TEST_CASE("swept mesh: random rigid motions, none late and early by at most the tolerance",
          "[contact][trap]") {
  Random random(21);
  const MeshShapeData ball = build_shape(make_icosphere(5e-3, 1));
  const MeshShapeData box = build_shape(make_box({8e-3, 6e-3, 4e-3}));
  const MeshShapeData soup = build_shape([] {
    Soup s = make_degenerate_soup(5, 40);
    for (Vec3& v : s.vertices) v *= 5e-3;
    return s;
  }());
  size_t hits = 0, unproven = 0;
  const auto n = sweep(400);
  for (size_t trial = 0; trial < n; ++trial) {
    const MeshShape tool = trial % 3 == 0 ? soup.view() : ball.view();
    const MeshShape object = box.view();
    const RigidMotion motion = random_motion(random, 10e-3, trial % 2 == 0 ? 0.3 : 3);
    if (meet(object, tool, motion.at(0))) continue;
    const MeshMeeting hit = impact(object, tool, motion);
    hits += hit.meets ? 1 : 0;
    unproven += hit.meets && !hit.is_proven ? 1 : 0;
    const int samples = 300;
    for (int i = 0; i <= samples; ++i) {
      const double t = hit.time * i / samples * (1 - 1e-12);
      if (meet(object, tool, motion.at(t))) FAIL("late: they meet at " << t << " of " << hit.time);
    }
    if (hit.meets && hit.is_proven) {
      CHECK(distance_of(object, tool, motion.at(hit.time)) <= 1e-6 * (1 + 1e-6));
    }
  }
  CHECK(hits > n / 20);
  CHECK(unproven <= n / 100);
}

TEST_CASE("swept mesh: A against B is B against A", "[contact][trap]") {
  Random random(22);
  const MeshShapeData ball = build_shape(make_icosphere(5e-3, 2));
  const MeshShapeData box = build_shape(make_box({8e-3, 6e-3, 4e-3}));
  size_t hits = 0;
  const size_t n = 400;
  for (size_t trial = 0; trial < n; ++trial) {
    // a straight motion, or a rotation about the tool's origin: seen from B it is of the same kind
    const bool turns = trial % 2 == 0;
    const RigidMotion any = random_motion(random, turns ? 0 : 15e-3, turns ? 3 : 0);
    const RigidMotion motion = motion_between(any.at(0), any.at(1), {});
    if (meet(box.view(), ball.view(), motion.at(0))) continue;
    const Vec3 centre_O = motion.centre_O;
    const RigidMotion seen = motion_between(inverse(motion.at(0)), inverse(motion.at(1)), centre_O);
    const MeshMeeting there = impact(box.view(), ball.view(), motion);
    const MeshMeeting back = impact(ball.view(), box.view(), seen);
    hits += there.meets ? 1 : 0;
    // a mere approach may count as a hit in one order and not in the other
    for (const MeshMeeting& hit : {there, back}) {
      if (!hit.meets) continue;
      CHECK(distance_of(box.view(), ball.view(), motion.at(hit.time)) <= 1.1e-6);
    }
  }
  CHECK(hits > n / 40);
}

TEST_CASE("swept mesh: a finer tolerance is later, never past the meeting", "[contact][trap]") {
  const BallAndBox pair(1);
  size_t hits = 0;
  const size_t n = 400;
  pair.move(23, n, [&](const RigidMotion& motion) {
    double last = 0, coarser = 0;
    const double length = norm(motion.way_O) + motion.angle * 10e-3;
    for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-8}) {
      const MeshMeeting hit = pair.hit(motion, tolerance);
      // another pair may be within the tolerance a little earlier
      CHECK(hit.time >= last - coarser / length);
      last = hit.time, coarser = tolerance;
    }
    hits += last < 1 ? 1 : 0;
    CHECK_FALSE(meet(pair.box.view(), pair.ball.view(), motion.at(last * (1 - 1e-12))));
  });
  CHECK(hits > n / 20);
}

TEST_CASE("swept mesh: what it remembers changes no answer", "[contact]") {
  const BallAndBox pair(2);
  SweptMesh remembers(pair.box.view(), pair.ball.view());
  pair.move(24, trials(300), [&](const RigidMotion& motion) {
    const MeshMeeting hit = remembers.time_of_impact(motion, kTolerance), cold = pair.hit(motion);
    CHECK(hit.meets == cold.meets);
    if (hit.meets && hit.time != cold.time) {
      pair.check_near(motion, std::min(hit.time, cold.time));
    }
  });
}

TEST_CASE("swept mesh: among all pairs the answer is that of the trees", "[contact]") {
  const BallAndBox pair(1);
  std::vector<TrianglePair> all;
  for (uint32_t a = 0; a < pair.box.mesh.triangles.size(); ++a) {
    for (uint32_t b = 0; b < pair.ball.mesh.triangles.size(); ++b) all.push_back({a, b});
  }
  size_t hits = 0;
  SweptMesh swept(pair.box.view(), pair.ball.view());
  pair.move(27, trials(400), [&](const RigidMotion& motion) {
    const MeshMeeting of_trees = pair.hit(motion);
    const MeshMeeting of_pairs = swept.time_of_impact(motion, kTolerance, all);
    CHECK_FALSE(swept.time_of_impact(motion, kTolerance, {}).meets);
    if (std::fabs(of_pairs.time - of_trees.time) > 1e-9) {
      pair.check_near(motion, std::min(of_pairs.time, of_trees.time));
    } else {
      CHECK(of_pairs.meets == of_trees.meets);
    }
    hits += of_pairs.meets ? 1 : 0;
    // that pair only, and all except it
    if (!of_pairs.meets) return;
    const TrianglePair alone[] = {of_pairs.pair};
    CHECK(swept.time_of_impact(motion, kTolerance, alone).time ==
          Approx(of_pairs.time).margin(1e-4));
    std::vector<TrianglePair> others = all;
    std::erase(others, of_pairs.pair);
    const MeshMeeting later = swept.time_of_impact(motion, kTolerance, others);
    CHECK(later.time >= of_pairs.time - 1e-4);
  });
  CHECK(hits > trials(400) / 40);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto bad = motion_between({}, {{nan, 0, 0}, {}}, {});
  CHECK(swept.time_of_impact(bad, kTolerance, {}).time == 0);
}

TEST_CASE("swept mesh: bolt in nut, a turn that jams and a screw that does not", "[contact]") {
  const MeshShapeData bolt = build_shape(make_bolt({{.grid = {48, 80}}}));
  const MeshShapeData nut = build_shape(make_nut({{.grid = {48, 32}}}));
  REQUIRE_FALSE(meet(nut.view(), bolt.view(), {}));
  // without the matching rotation the thread is hit
  const RigidMotion pull = motion_between({}, {{0, 0, 0.5e-3}, {}}, {});
  const MeshMeeting jam = impact(nut.view(), bolt.view(), pull);
  REQUIRE(jam.meets);
  CHECK_FALSE(meet(nut.view(), bolt.view(), pull.at(jam.time * (1 - 1e-12))));
  CHECK(meet(nut.view(), bolt.view(), pull.at(jam.time + 0.02)));
}

TEST_CASE("swept mesh: what is nearer than the tolerance can leave and slide along",
          "[contact][trap]") {
  const MeshShapeData box = build_shape(make_box({20e-3, 20e-3, 20e-3}));
  // rotated about the normal; the faces 0.2 µm apart
  const Quat turned = from_rotation_vector({0, 0, 0.4});
  const Vec3 at{1e-3, 2e-3, 20e-3 + 0.2e-6};
  const auto ask = [&](const Vec3& way, double spin) {
    const Pose to{at + way, from_rotation_vector({0, 0, spin}) * turned};
    return impact(box.view(), box.view(), motion_between({at, turned}, to, {}));
  };
  CHECK_FALSE(ask({5e-3, -3e-3, 0}, 0).meets);
  CHECK_FALSE(ask({0, 0, 1e-3}, 0).meets);
  CHECK_FALSE(ask({1e-3, 0, 1e-5}, 0.5).meets);
  const MeshMeeting down = ask({0, 0, -1e-3}, 0);
  REQUIRE(down.meets);
  CHECK(down.time <= 0.2e-3);
  CHECK(down.time >= 0.1e-3 * (1 - 1e-6));
}

TEST_CASE("swept mesh: pushed to where they meet, and again, it can be pulled off",
          "[contact][trap]") {
  const MeshShapeData box = build_shape(make_box({20e-3, 20e-3, 20e-3}));
  Random random(26);
  SweptMesh swept(box.view(), box.view());
  const size_t n = 200;
  size_t held = 0;
  for (size_t trial = 0; trial < n; ++trial) {
    const Quat q = from_rotation_vector(trial % 2 == 0 ? Vec3{0, 0, random.uniform(0, 1)}
                                                       : random.uniform(0, 1) * random.direction());
    Pose X_OT{{random.uniform(-5e-3, 5e-3), random.uniform(-5e-3, 5e-3), 40e-3}, q};
    for (int push = 0; push < 5; ++push) {
      const Vec3 down = X_OT.p + Vec3{random.uniform(-1e-3, 1e-3), 0, -20e-3};
      const RigidMotion motion = motion_between(X_OT, {down, q}, {});
      const MeshMeeting hit = swept.time_of_impact(motion, kTolerance);
      REQUIRE(hit.meets);
      X_OT = motion.at(hit.time);
      REQUIRE_FALSE(meet(box.view(), box.view(), X_OT));
    }
    const RigidMotion pull = motion_between(X_OT, {X_OT.p + Vec3{0, 0, 5e-3}, q}, {});
    held += swept.time_of_impact(pull, kTolerance).meets ? 1 : 0;
  }
  CHECK(held == 0);
}

TEST_CASE("swept mesh: nothing to meet, and motions that are not finite", "[contact]") {
  const MeshShapeData box = build_shape(make_box({8e-3, 6e-3, 4e-3}));
  const MeshShapeData none = build_shape({});
  const RigidMotion still = motion_between({{0.1, 0, 0}, {}}, {{0.1, 0, 0}, {}}, {});
  CHECK_FALSE(impact(box.view(), none.view(), still).meets);
  CHECK_FALSE(impact(none.view(), box.view(), still).meets);
  CHECK_FALSE(impact(box.view(), box.view(), still).meets);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Pose& bad : {Pose{{nan, 0, 0}, {}}, Pose{{0, 0, 0}, {nan, 0, 0, 1}}}) {
    const MeshMeeting hit = impact(box.view(), box.view(), motion_between({}, bad, {}));
    CHECK(hit.meets);
    CHECK_FALSE(hit.is_proven);
    CHECK(hit.time == 0);
  }
}

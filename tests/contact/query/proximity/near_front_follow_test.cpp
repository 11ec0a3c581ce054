// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for NearFront::follow: pairs that are not suspects must not meet during the motion. Ground
// truth: all pairs of triangles at many poses of the motion.
#include "contact/query/proximity/near_front.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "contact/query/box/rigid_motion.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

using Pairs = std::vector<TrianglePair>;

struct Ball {
  Vec3 centre;
  double radius = 0;
};

Ball ball_of(const Corners& corners) {
  Ball ball{(corners[0] + corners[1] + corners[2]) / 3, 0};
  for (const Vec3& p : corners) ball.radius = std::max(ball.radius, norm(p - ball.centre));
  return ball;
}

std::vector<Ball> balls_of(const TriangleMesh& mesh) {
  std::vector<Ball> balls;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    balls.push_back(ball_of(corners_of(mesh, t)));
  return balls;
}

/// Pairs that come this near at some time of the motion.
Pairs met_on_the_way(const MeshShapeData& A, const MeshShapeData& B, const RigidMotion& way,
                     double nearer, int samples) {
  const TriangleMesh a = A.mesh.view(), b = B.mesh.view();
  const std::vector<Ball> balls_a = balls_of(a), balls_b = balls_of(b);
  Pairs met;
  for (int k = 0; k <= samples; ++k) {
    const Pose X_AB = way.at(static_cast<double>(k) / samples);
    for (uint32_t j = 0; j < balls_b.size(); ++j) {
      const Vec3 centre = X_AB * balls_b[j].centre;
      for (uint32_t i = 0; i < balls_a.size(); ++i) {
        const double reach = balls_a[i].radius + balls_b[j].radius + nearer;
        if (norm_squared(centre - balls_a[i].centre) > reach * reach) continue;
        const Corners tool = corners_of(b, j, X_AB);
        if (triangle_distance(corners_of(a, i), tool).distance <= nearer) met.push_back({i, j});
      }
    }
  }
  std::sort(met.begin(), met.end());
  met.erase(std::unique(met.begin(), met.end()), met.end());
  return met;
}

/// Number of them that are not suspects.
size_t forgotten(const NearFront& front, const Pairs& met) {
  Pairs suspects(front.suspects().begin(), front.suspects().end());
  std::sort(suspects.begin(), suspects.end());
  return static_cast<size_t>(std::count_if(met.begin(), met.end(), [&](const TrianglePair& pair) {
    return !std::binary_search(suspects.begin(), suspects.end(), pair);
  }));
}

double radius_of(const MeshShapeData& shape) {
  double radius = 0;
  for (const Vec3& v : shape.mesh.vertices) radius = std::max(radius, norm(v));
  return radius;
}

/// Two small boxes at x = ±half.
Soup make_two_boxes(double half, double edge) {
  Soup soup;
  for (const double x : {-half, half}) append(soup, make_box({edge, edge, edge}), {x, 0, 0});
  return soup;
}

}  // namespace

TEST_CASE("near front: what it does not suspect does not meet on the way", "[contact][trap]") {
  const primitive::Hole fit{{10e-3, 20e-3, {16, 4}}, 0.3e-3, 24e-3};
  struct Couple {
    MeshShapeData A, B;
    double apart;  // distance of their origins, around which they meet [m]
  };
  std::vector<Couple> couples;
  couples.push_back(
      {build_shape(make_bumpy_ball(1, 0.03, 2)), build_shape(make_bumpy_ball(2, 0.015, 2)), 0.042});
  couples.push_back(
      {build_shape(make_box({0.04, 0.03, 0.02})), build_shape(make_box({0.02, 0.01, 0.03})), 0.03});
  couples.push_back({build_shape(make_hole(fit)), build_shape(make_peg(fit)), 0});
  couples.push_back(
      {build_shape(make_rough_sheet(3, 12, 0.8)), build_shape(make_bumpy_ball(4, 0.02, 2)), 0.018});
  Random random(5);
  size_t n_met = 0, n_new = 0;
  for (size_t c = 0; c < couples.size(); ++c) {
    const auto& [A, B, apart] = couples[c];
    NearFront front(A.view(), B.view());
    const double radius = radius_of(B);
    Pose X = {{0, 0, apart}, {}}, earlier = X;
    double band = 1e-3 * radius;
    for (size_t tick = 0; tick < trials(100); ++tick) {
      if (tick % 7 == 6) band = radius * std::pow(10, random.uniform(-4, -1.5));
      const double way = 2 * radius * std::pow(10, random.uniform(-4, -1));
      const double turn = random.uniform(0, 1) * std::sqrt(8 * 0.45 * band / radius);
      // to and fro around the place where they meet
      const double off = norm(X.p) - apart;
      const Vec3 back = std::fabs(off) > 1e-3 ? -off / std::fabs(off) * normalized(X.p) : Vec3{};
      Pose next{X.p + way * normalized(random.direction() + back),
                normalized(from_rotation_vector(turn * random.direction()) * X.q)};
      RigidMotion motion = motion_between(X, next, {});
      if (tick % 11 == 10) next = earlier, motion = motion_between(X, next, {});
      const bool is_bent = off_the_chord(motion, radius, 1) > 0.5 * band;
      if (is_bent || tick % 5 == 4) {
        front.update(next, band);
        REQUIRE(front.suspects().empty());
      } else {
        const bool is_first = front.is_first();
        front.follow(motion, next, band);
        const Pairs met = met_on_the_way(A, B, motion, 0, 12);
        CAPTURE(c, tick, way, turn, band, met.size(), front.suspects().size());
        REQUIRE((is_first || forgotten(front, met) == 0));
        n_met += met.size();
        // neither end of the motion shows it
        const Pairs at_first = met_on_the_way(A, B, motion_between(X, X, {}), band, 1);
        const Pairs at_last = met_on_the_way(A, B, motion_between(next, next, {}), band, 1);
        n_new += static_cast<size_t>(std::count_if(met.begin(), met.end(), [&](const auto& pair) {
          return !std::binary_search(at_first.begin(), at_first.end(), pair) &&
                 !std::binary_search(at_last.begin(), at_last.end(), pair);
        }));
      }
      if (tick % 13 == 0) earlier = X;
      X = next;
    }
  }
  CHECK((n_met > 1000 || kSlowdown > 1));
  CHECK((n_new > 100 || kSlowdown > 1));
}

TEST_CASE(
    "near front: the other half of a pair that its parent stands for is not forgotten on the "
    "way",
    "[contact][trap]") {
  // two boxes, and a third that passes through one of them and ends far from both: their parent
  // must not wait for both, whichever is visited first
  const MeshShapeData A = build_shape(make_two_boxes(5e-3, 0.5e-3));
  const MeshShapeData B = build_shape(make_box({0.5e-3, 0.5e-3, 0.5e-3}));
  size_t n_met = 0;
  for (const double through : {-5e-3, 5e-3}) {
    for (int k = 0; k < 40; ++k) {
      NearFront front(A.view(), B.view());
      const Pose first{{through, 3e-3 + 1e-4 * k, 0}, {}};
      const Pose last{first.p - Vec3{0, 10e-3, 0}, {}};
      front.update(first, 1e-4);
      front.follow(motion_between(first, last, {}), last, 1e-4);
      const Pairs met = met_on_the_way(A, B, motion_between(first, last, {}), 0, 200);
      CAPTURE(through, k);
      REQUIRE(forgotten(front, met) == 0);
      n_met += met.size();
    }
  }
  CHECK(n_met > 0);
}

TEST_CASE("near front: what is near at first and gone at last may have met on a bend",
          "[contact][trap]") {
  // a pendulum of 50 mm over a floor: it dips into it during the motion and ends beyond the band
  const double length = 50e-3, band = 1e-3;
  const MeshShapeData A = build_shape(make_box({20e-3, 20e-3, 2e-3}));
  const MeshShapeData B = build_shape(make_box({0.1e-3, 0.1e-3, 0.1e-3}));
  const Vec3 hinge_B{0, 0, length};
  const double from = -0.3 * std::sqrt(band / length), to = 1.48 * std::sqrt(band / length);
  const auto swung = [&](double angle) {
    const Quat q = from_rotation_vector({0, -angle, 0});
    const Vec3 hinge_A{0, 0, 1e-3 + 0.05e-3 - 0.01e-3 + length};
    return Pose{hinge_A - rotate(q, hinge_B), q};
  };
  const RigidMotion motion = motion_between(swung(from), swung(to), hinge_B);
  REQUIRE(off_the_chord(motion, length, 1) < 0.45 * band);
  NearFront front(A.view(), B.view());
  front.update(swung(from), band);
  front.follow(motion, swung(to), band);
  const Pairs met = met_on_the_way(A, B, motion, 0, 200);
  REQUIRE(!met.empty());
  CHECK(forgotten(front, met) == 0);
}

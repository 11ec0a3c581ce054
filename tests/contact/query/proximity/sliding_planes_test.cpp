// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/query/proximity/sliding_planes.cpp and leaf_bounds.cpp. Ground truth: the
// points themselves, in double, at every pose.
#include "contact/query/proximity/sliding_planes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "contact/query/proximity/leaf_bounds.h"
#include "contact/query/triangle/triangle_distance.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kReach = 0.05;  // of B [m]

/// A ball of B that contains these points, and a plane of A that they were on one side of.
struct Piece {
  SlidingPlane plane;
  std::vector<Vec3> points_B;
  double offset = 0;  // of the plane along its normal [m]

  /// Distance of the nearest point from the plane.
  double distance(const Pose& X_AB) const {
    double least = 1e9;
    for (const Vec3& p : points_B) least = std::min(least, dot(plane.normal_A, X_AB * p) - offset);
    return least;
  }
};

Piece random_piece(Random& random, const Pose& X_AB) {
  Piece piece;
  SlidingPlane& plane = piece.plane;
  plane.normal_A = SlidingPlanes::rounded(random.direction());
  plane.centre_B = random.uniform(0, 0.9 * kReach) * random.direction();
  plane.radius = random.uniform(0, 0.1 * kReach);
  // on the ball and nowhere else: no other point is nearer
  for (int k = 0; k < 20; ++k) {
    piece.points_B.push_back(plane.centre_B + plane.radius * random.direction());
  }
  piece.points_B.push_back(plane.centre_B -
                           plane.radius * rotate(conjugate(X_AB.q), plane.normal_A));
  plane.gap = 1e-3 * random.uniform(0, 1);
  piece.offset = piece.distance(X_AB) - plane.gap;
  return piece;
}

Pose stepped(const Pose& X_AB, Random& random, double way, double turn) {
  return {X_AB.p + way * random.direction(),
          normalized(from_rotation_vector(turn * random.direction()) * X_AB.q)};
}

bool is_in(const std::vector<SlidingPlanes::UsedUp>& used_up, uint32_t owner) {
  return std::any_of(used_up.begin(), used_up.end(),
                     [&](const auto& one) { return one.owner == owner; });
}

}  // namespace

TEST_CASE("sliding planes: a gap is never wider than it is, and little narrower after a slide") {
  Random random(1);
  for (size_t trial = 0; trial < trials(200); ++trial) {
    Pose X = random.pose(0.1);
    SlidingPlanes planes;
    std::vector<Piece> pieces;
    for (uint32_t owner = 0; owner < 37; ++owner) {
      pieces.push_back(random_piece(random, X));
      planes.put(owner, pieces.back().plane);
    }
    const double way = std::pow(10, random.uniform(-7, -3));
    const double turn = trial % 3 == 0 ? 0 : way / kReach;
    double turned = 0;
    for (int step = 0; step < 20; ++step) {
      const Pose next = stepped(X, random, way, turn);
      const PoseChange change(X, next, kReach);
      turned += turn;
      std::vector<SlidingPlanes::UsedUp> used_up;
      planes.move(change, 1e-5, used_up);
      X = next;
      for (uint32_t owner = 0; owner < pieces.size(); ++owner) {
        const Piece& piece = pieces[owner];
        const double gap = planes.gap(owner), distance = piece.distance(X);
        CAPTURE(trial, step, owner, way, turn);
        // a slack that is used up gives no bound
        REQUIRE((gap <= distance || gap < 0));
        // allowed loss: at most twice the effect of rotation on the ball, and rounding
        REQUIRE(gap >=
                distance - 2.01 * turned * piece.plane.radius - 1e-5 * way * (step + 1) - 3e-8);
        REQUIRE(is_in(used_up, owner) == !(gap > 1e-5));
        for (const Vec3& p : piece.points_B) {
          REQUIRE(norm(next * p - (X * p)) <=
                  change.most(piece.plane.centre_B, piece.plane.radius));
        }
      }
    }
  }
}

TEST_CASE("sliding planes: each owner keeps its own through all that come and go") {
  Random random(2);
  SlidingPlanes planes;
  std::map<uint32_t, double> expected;
  for (size_t k = 0; k < trials(20000); ++k) {
    const auto owner = static_cast<uint32_t>(random.index(300));
    if (expected.count(owner) != 0 && k % 3 != 0) {
      planes.take_out(owner);
      expected.erase(owner);
    } else {
      const double gap = random.uniform(0.1, 1);
      planes.put(owner, {{1, 0, 0}, gap, {}, 0});
      expected[owner] = gap;
    }
    REQUIRE(planes.size() == expected.size());
    if (k % 50 != 0) continue;
    for (uint32_t i = 0; i < 300; ++i) REQUIRE(planes.has(i) == (expected.count(i) != 0));
    for (const auto& [i, gap] : expected) REQUIRE(planes.gap(i) == Approx(gap).epsilon(1e-3));
    // all of them, each once, and none that was removed
    std::vector<SlidingPlanes::UsedUp> all;
    planes.move(PoseChange({}, {}, kReach), 2, all);
    REQUIRE(all.size() == expected.size());
    for (const auto& one : all) REQUIRE(expected.count(one.owner) != 0);
  }
}

TEST_CASE("leaf bounds: triangles are at least so far apart, and are asked when they may be near") {
  Random random(3);
  size_t n_asked = 0, n_kept = 0;
  for (size_t trial = 0; trial < trials(2000); ++trial) {
    Corners a[2], b[3];
    const double size = 1e-3;
    for (Corners& t : a) {
      for (Vec3& p : t) p = random.in_box(Vec3{-size, -size, -size}, Vec3{size, size, size});
    }
    for (Corners& t : b) {
      for (Vec3& p : t) {
        p = Vec3{0.02, 0, 0} + random.in_box(Vec3{-size, -size, -size}, Vec3{size, size, size});
      }
    }
    std::vector<LeafBounds> bounds(1);
    bounds[0].pair = 7;
    bounds[0].begin(2, 3, 2 * size, 2 * size);
    bounds[0].set_ball({0.02, 0, 0}, std::sqrt(3.0) * size);
    Pose X{Vec3{-0.02, 0, 0} + random.uniform(0, 5e-3) * random.direction(), {}};
    const auto corners_at = [&](const Corners& t) { return Corners{X * t[0], X * t[1], X * t[2]}; };
    const double band = 1e-4;
    for (int step = 0; step < 10; ++step) {
      for (size_t k = 0; k < LeafBounds::kPairs; ++k) {
        const size_t i = k % 4, j = k / 4;
        const bool is_asked = (bounds[0].asked >> k & 1) != 0;
        REQUIRE((!is_asked || (i < 2 && j < 3)));
        if (i >= 2 || j >= 3) continue;
        const TriangleDistance d = triangle_distance(a[i], corners_at(b[j]));
        if (step > 0) REQUIRE(static_cast<double>(bounds[0].at_least[k]) <= d.distance);
        if (!is_asked) {
          REQUIRE(d.distance > band);
          ++n_kept;
          continue;
        }
        ++n_asked;
        const Vec3 n = d.distance > 0 ? normalized(d.point_b - d.point_a) : Vec3{};
        bounds[0].set(k, n, d.distance);
      }
      const Pose next = stepped(X, random, 2e-4, 0.01);
      std::vector<uint32_t> asked;
      move_along(bounds, PoseChange(X, next, 0.03), band, -1, asked);
      REQUIRE(asked.size() == (bounds[0].asked != 0 ? 1 : 0));
      if (!asked.empty()) REQUIRE(asked[0] == 7);
      X = next;
    }
  }
  CHECK(n_asked > 0);
  CHECK(n_kept > 0);
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/swept_pair.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/feature_queries.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kPairTolerance = 1e-6;  // [m]

}  // namespace

TEST_CASE("swept pair: a vertex through a face, in closed form", "[contact]") {
  const std::array<SweptPoint, 3> face{
      {{{-1, -1, 0}, {-1, -1, 0}}, {{2, -1, 0}, {2, -1, 0}}, {{-1, 2, 0}, {-1, 2, 0}}}};
  const auto hit = vertex_face_meeting({{0, 0, 1}, {0, 0, -1}}, face, 1e-9);
  REQUIRE(hit);
  CHECK(hit->is_proven);
  CHECK(hit->time <= 0.5);
  CHECK(hit->time >= 0.5 - 1e-9);
  CHECK_FALSE(vertex_face_meeting({{0, 0, 1}, {0, 0, 1e-3}}, face, kPairTolerance));
  CHECK_FALSE(vertex_face_meeting({{3, 3, 1}, {3, 3, -1}}, face, kPairTolerance));
  // within the square, beyond the third side
  CHECK_FALSE(vertex_face_meeting({{1.2, 1.2, 1}, {1.2, 1.2, -1}}, face, kPairTolerance));
}

TEST_CASE("swept pair: two edges pass each other, in closed form", "[contact]") {
  const std::array<SweptPoint, 2> still{{{{-1, 0, 0}, {-1, 0, 0}}, {{1, 0, 0}, {1, 0, 0}}}};
  const auto falling = [](double y, double from, double to) {
    return std::array<SweptPoint, 2>{
        {{{0, y - 1, from}, {0, y - 1, to}}, {{0, y + 1, from}, {0, y + 1, to}}}};
  };
  const auto hit = edge_edge_meeting(still, falling(0.2, 1, -3), 1e-9);
  REQUIRE(hit);
  CHECK(hit->time <= 0.25);
  CHECK(hit->time >= 0.25 - 1e-9);
  CHECK_FALSE(edge_edge_meeting(still, falling(1.2, 1, -3), kPairTolerance));
  CHECK_FALSE(edge_edge_meeting(still, falling(0, 1, 0.1), kPairTolerance));
}

TEST_CASE("swept pair: parallel edges that fall on one another meet", "[contact][trap]") {
  const auto edge = [](double x, double from, double to) {
    return std::array<SweptPoint, 2>{
        {{{x, 0, from}, {x, 0, to}}, {{x + 1, 0, from}, {x + 1, 0, to}}}};
  };
  const auto hit = edge_edge_meeting(edge(0, 0, 0), edge(0.5, 1, -1), kPairTolerance);
  REQUIRE(hit);
  CHECK(hit->time <= 0.5);
  CHECK(hit->time >= 0.49);
  // collinear, one behind the other: they come no nearer than 0.1
  CHECK_FALSE(edge_edge_meeting(edge(0, 0, 0), edge(1.1, 1, -1), kPairTolerance));
}

TEST_CASE("swept pair: never later than a meeting that was made", "[contact][trap]") {
  check_made_meetings(trials(20000), [](const std::array<SweptPoint, 4>& corners, bool is_face) {
    const auto& [a, b, c, d] = corners;
    return is_face ? vertex_face_meeting(a, {b, c, d}, 1e-8)
                   : edge_edge_meeting({a, b}, {c, d}, 1e-8);
  });
}

TEST_CASE("swept pair: corners that are not finite meet at once, unproven", "[contact]") {
  check_not_finite([](const SweptPoint& vertex, const std::array<SweptPoint, 3>& face) {
    return vertex_face_meeting(vertex, face, kPairTolerance);
  });
  const std::array<Vec3, 3> still{{{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
    const RigidMotion motion = motion_between({{0, 0, 1}, {}}, {{0, 0, bad}, {}}, {});
    const MotionStretch stretch = stretch_of(motion, 0, 1, 1);
    check_unproven_at_once(
        first_meeting(FeaturePath::of_vertex_and_face(stretch, {0, 0, 0}, still), kPairTolerance));
  }
}

TEST_CASE("swept pair: a rod that turns half round passes a post that straight ways miss",
          "[contact][trap]") {
  // a rod of 1 m about its middle; a thin post is clear of its first and last pose
  const std::array<Vec3, 2> rod{{{-0.5, 0, 0}, {0.5, 0, 0}}};
  const std::array<Vec3, 2> post{{{0, 0.4, -0.1}, {0, 0.4, 0.1}}};
  const RigidMotion half_turn =
      motion_between({{}, {}}, {{}, from_rotation_vector({0, 0, 3.1})}, {});
  const MotionStretch stretch = stretch_of(half_turn, 0, 1, 1);
  const auto hit = first_meeting(FeaturePath::of_edges(stretch, rod, post), kPairTolerance);
  REQUIRE(hit);
  CHECK(hit->is_proven);
  const double truth = 1.5707963267948966 / 3.1;
  CHECK(hit->time <= truth);
  CHECK(hit->time >= truth - 1e-5);
  const Pose end = half_turn.at(1);
  const auto straight =
      edge_edge_meeting({{{rod[0], end * rod[0]}, {rod[1], end * rod[1]}}},
                        {{{post[0], post[0]}, {post[1], post[1]}}}, kPairTolerance);
  CHECK_FALSE(straight);
}

TEST_CASE("swept pair: rigid motions, never late against dense samples", "[contact][trap]") {
  check_rigid_queries(trials(5000), [](const RigidQuery& query, const MotionStretch& stretch) {
    return first_meeting(query.path(stretch), 1e-7);
  });
}

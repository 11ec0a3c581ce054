// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/swept_pair.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

struct Query {
  std::array<SweptPoint, 4> points;
};

std::optional<SweptMeeting> ask(const Query& query, bool is_face, const SweptPairOptions& options) {
  const auto& [a, b, c, d] = query.points;
  if (is_face) return vertex_face_meeting(a, {b, c, d}, options);
  return edge_edge_meeting({a, b}, {c, d}, options);
}

}  // namespace

TEST_CASE("swept pair: a vertex through a face, in closed form", "[contact]") {
  const std::array<SweptPoint, 3> face{
      {{{-1, -1, 0}, {-1, -1, 0}}, {{2, -1, 0}, {2, -1, 0}}, {{-1, 2, 0}, {-1, 2, 0}}}};
  const auto hit = vertex_face_meeting({{0, 0, 1}, {0, 0, -1}}, face, {1e-9, 100000});
  REQUIRE(hit);
  CHECK(hit->is_proven);
  CHECK(hit->time <= 0.5);
  CHECK(hit->time >= 0.5 - 1e-9);
  CHECK_FALSE(vertex_face_meeting({{0, 0, 1}, {0, 0, 1e-3}}, face, {}));
  CHECK_FALSE(vertex_face_meeting({{3, 3, 1}, {3, 3, -1}}, face, {}));
  // within the square, beyond the third side
  CHECK_FALSE(vertex_face_meeting({{1.2, 1.2, 1}, {1.2, 1.2, -1}}, face, {}));
}

TEST_CASE("swept pair: two edges pass each other, in closed form", "[contact]") {
  const std::array<SweptPoint, 2> still{{{{-1, 0, 0}, {-1, 0, 0}}, {{1, 0, 0}, {1, 0, 0}}}};
  const auto falling = [](double y, double from, double to) {
    return std::array<SweptPoint, 2>{
        {{{0, y - 1, from}, {0, y - 1, to}}, {{0, y + 1, from}, {0, y + 1, to}}}};
  };
  const auto hit = edge_edge_meeting(still, falling(0.2, 1, -3), {1e-9, 100000});
  REQUIRE(hit);
  CHECK(hit->time <= 0.25);
  CHECK(hit->time >= 0.25 - 1e-9);
  CHECK_FALSE(edge_edge_meeting(still, falling(1.2, 1, -3), {}));
  CHECK_FALSE(edge_edge_meeting(still, falling(0, 1, 0.1), {}));
}

TEST_CASE("swept pair: parallel edges that fall on one another meet", "[contact][trap]") {
  const auto edge = [](double x, double from, double to) {
    return std::array<SweptPoint, 2>{
        {{{x, 0, from}, {x, 0, to}}, {{x + 1, 0, from}, {x + 1, 0, to}}}};
  };
  const auto hit = edge_edge_meeting(edge(0, 0, 0), edge(0.5, 1, -1), {});
  REQUIRE(hit);
  CHECK(hit->time <= 0.5);
  CHECK(hit->time >= 0.49);
  // collinear, one behind the other: they come no nearer than 0.1
  CHECK_FALSE(edge_edge_meeting(edge(0, 0, 0), edge(1.1, 1, -1), {}));
}

TEST_CASE("swept pair: never later than a meeting that was made", "[contact][trap]") {
  Random random(4);
  double latest = -1, earliest = 0;
  for (size_t k = 0; k < trials(20000); ++k) {
    Query query;
    const bool is_face = k % 2 == 0;
    const size_t moving = is_face ? 1 : 2;
    // a tool's features of millimetres, moved by a hand
    const Vec3 way = 2e-3 * random.direction();
    for (size_t i = 0; i < 4; ++i) {
      const Vec3 at = random.in_box({-1e-3, -1e-3, -1e-3}, {1e-3, 1e-3, 1e-3});
      query.points[i] = {at, i < moving ? at + way + 2e-4 * random.direction() : at};
    }
    // placed such that a point on one meets a point on the other at a known time
    const double time = random.uniform(0, 1), u = random.uniform(0.05, 0.5),
                 v = random.uniform(0.05, 0.45);
    std::array<Vec3, 4> p;
    for (size_t i = 0; i < 4; ++i) {
      p[i] = (1 - time) * query.points[i].from + time * query.points[i].to;
    }
    const Vec3 apart = is_face ? p[0] - p[1] - u * (p[2] - p[1]) - v * (p[3] - p[1])
                               : p[0] + u * (p[1] - p[0]) - p[2] - v * (p[3] - p[2]);
    for (size_t i = 0; i < moving; ++i) query.points[i].from -= apart, query.points[i].to -= apart;
    const auto hit = ask(query, is_face, {1e-8, k % 4 < 2 ? 0u : 100000u});
    REQUIRE(hit);
    latest = std::max(latest, hit->time - time);
    // there may have been an earlier contact, of two edges or a face that turns
    earliest += hit->time < time - 1e-3 ? 1 : 0;
  }
  CHECK(latest <= 1e-12);
  CHECK(earliest < 0.02 * static_cast<double>(trials(20000)));
}

TEST_CASE("swept pair: corners that are not finite meet at once, unproven", "[contact]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::array<SweptPoint, 3> face{
      {{{-1, -1, 0}, {-1, -1, 0}}, {{2, -1, 0}, {2, -1, 0}}, {{-1, 2, 0}, {-1, 2, 0}}}};
  const std::array<Vec3, 3> still{{{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}}};
  for (const uint32_t budget : {0u, 500u}) {
    for (const double bad : {nan, infinity, -infinity}) {
      for (const SweptPoint& vertex :
           {SweptPoint{{0, 0, 1}, {0, 0, bad}}, SweptPoint{{bad, 0, 1}, {0, 0, -1}}}) {
        const auto hit = vertex_face_meeting(vertex, face, {1e-6, budget});
        REQUIRE(hit);
        CHECK(hit->time == 0);
        CHECK_FALSE(hit->is_proven);
      }
      const RigidMotion motion = motion_between({{0, 0, 1}, {}}, {{0, 0, bad}, {}}, {});
      const auto hit =
          vertex_face_meeting(stretch_of(motion, 0, 1, 1), {0, 0, 0}, still, {1e-6, budget});
      REQUIRE(hit);
      CHECK(hit->time == 0);
      CHECK_FALSE(hit->is_proven);
    }
  }
}

TEST_CASE("swept pair: a rod that turns half round passes a post that straight ways miss",
          "[contact][trap]") {
  // a rod of 1 m about its middle; a thin post is clear of its first and last pose
  const std::array<Vec3, 2> rod{{{-0.5, 0, 0}, {0.5, 0, 0}}};
  const std::array<Vec3, 2> post{{{0, 0.4, -0.1}, {0, 0.4, 0.1}}};
  const RigidMotion half_turn =
      motion_between({{}, {}}, {{}, from_rotation_vector({0, 0, 3.1})}, {});
  const auto hit = edge_edge_meeting(stretch_of(half_turn, 0, 1, 1), rod, post, {});
  REQUIRE(hit);
  CHECK(hit->is_proven);
  const double truth = 1.5707963267948966 / 3.1;
  CHECK(hit->time <= truth);
  CHECK(hit->time >= truth - 1e-5);
  const Pose end = half_turn.at(1);
  const auto straight = edge_edge_meeting({{{rod[0], end * rod[0]}, {rod[1], end * rod[1]}}},
                                          {{{post[0], post[0]}, {post[1], post[1]}}}, {});
  CHECK_FALSE(straight);
}

TEST_CASE("swept pair: rigid motions, never late against dense samples", "[contact][trap]") {
  Random random(5);
  size_t meetings = 0, unproven = 0;
  for (size_t k = 0; k < trials(5000); ++k) {
    const size_t kind = k % 3;
    const Pose from = random.pose(2e-3);
    const Pose to{from.p + 2e-3 * random.direction(),
                  from_rotation_vector(random.uniform(0, 1) * random.direction()) * from.q};
    const RigidMotion motion = motion_between(from, to, 1e-3 * random.direction());
    std::array<Vec3, 4> p;
    for (Vec3& v : p) v = random.in_box({-2e-3, -2e-3, -2e-3}, {2e-3, 2e-3, 2e-3});
    const SweptPairOptions options{1e-7, k % 2 == 0 ? 0u : 100000u};
    const MotionStretch stretch = stretch_of(motion, 0, 1, 4e-3);
    const auto hit = kind == 0   ? vertex_face_meeting(stretch, p[0], {p[1], p[2], p[3]}, options)
                     : kind == 1 ? face_vertex_meeting(stretch, {p[1], p[2], p[3]}, p[0], options)
                                 : edge_edge_meeting(stretch, {p[0], p[1]}, {p[2], p[3]}, options);
    meetings += hit ? 1 : 0;
    unproven += hit && !hit->is_proven ? 1 : 0;
    // signed volumes change sign where features may pass; dense in time, the least distance
    const double end = hit ? hit->time : 1;
    const int steps = 200;
    double last = 0;
    for (int step = 0; step <= steps; ++step) {
      const double t = end * step / steps * (1 - 1e-6);
      const Pose X = motion.at(t);
      const auto tool = [&](size_t i) { return X * p[i]; };
      const Vec3 a = kind == 1 ? p[0] : tool(0), b = kind == 0 ? p[1] : tool(1),
                 c = kind == 1 ? tool(2) : p[2], d = kind == 1 ? tool(3) : p[3];
      const double volume =
          kind == 2 ? dot(c - a, cross(b - a, d - c)) : dot(a - b, cross(c - b, d - b));
      const bool passed = step > 0 && (volume > 0) != (last > 0);
      last = volume;
      if (!passed) continue;
      // in the plane, or on both lines: within both features?
      double u = 0, v = 0;
      if (kind == 2) {
        const Vec3 e = b - a, f = d - c, n = cross(e, f), r = c - a;
        u = dot(cross(r, f), n) / dot(n, n), v = dot(cross(r, e), n) / dot(n, n);
        REQUIRE_FALSE((u > 0.01 && u < 0.99 && v > 0.01 && v < 0.99));
      } else {
        const Vec3 e = c - b, f = d - b, n = cross(e, f), r = a - b;
        u = dot(cross(r, f), n) / dot(n, n), v = dot(cross(e, r), n) / dot(n, n);
        REQUIRE_FALSE((u > 0.01 && v > 0.01 && u + v < 0.98));
      }
    }
  }
  CAPTURE(meetings, unproven);
  CHECK(meetings > trials(5000) / 50);
  CHECK(unproven == 0);
}

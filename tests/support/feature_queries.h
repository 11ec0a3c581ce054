// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "contact/query/sweep/feature_path.h"
#include "contact/query/sweep/swept_pair.h"
#include "tests/support/meshes.h"

namespace haptic::test {

/// Two features whose corners go straight and that meet at a time, maybe at others before.
struct MadeMeeting {
  std::array<SweptPoint, 4> corners;  // vertex and face, or edge and edge
  double time;
};

/// A tool's features of millimetres, moved by a hand, placed such that a point on one meets a point
/// on the other at a known time.
inline MadeMeeting made_meeting(Random& random, bool is_face) {
  MadeMeeting made{};
  const size_t moving = is_face ? 1 : 2;
  const Vec3 way = 2e-3 * random.direction();
  for (size_t i = 0; i < 4; ++i) {
    const Vec3 at = random.in_box({-1e-3, -1e-3, -1e-3}, {1e-3, 1e-3, 1e-3});
    made.corners[i] = {at, i < moving ? at + way + 2e-4 * random.direction() : at};
  }
  made.time = random.uniform(0, 1);
  const double u = random.uniform(0.05, 0.5), v = random.uniform(0.05, 0.45);
  std::array<Vec3, 4> p;
  for (size_t i = 0; i < 4; ++i) {
    p[i] = (1 - made.time) * made.corners[i].from + made.time * made.corners[i].to;
  }
  const Vec3 apart = is_face ? p[0] - p[1] - u * (p[2] - p[1]) - v * (p[3] - p[1])
                             : p[0] + u * (p[1] - p[0]) - p[2] - v * (p[3] - p[2]);
  for (size_t i = 0; i < moving; ++i) made.corners[i].from -= apart, made.corners[i].to -= apart;
  return made;
}

/// Features of a tool in rigid motion past fixed ones.
struct RigidQuery {
  enum Kind { kVertexFace, kFaceVertex, kEdges };  // the tool's first
  Kind kind;
  RigidMotion motion;
  std::array<Vec3, 4> corners;  // vertex, then face; or edge of the tool, then of the object

  FeaturePath path(const MotionStretch& stretch) const {
    const auto& [a, b, c, d] = corners;
    return kind == kVertexFace   ? FeaturePath::of_vertex_and_face(stretch, a, {b, c, d})
           : kind == kFaceVertex ? FeaturePath::of_face_and_vertex(stretch, {b, c, d}, a)
                                 : FeaturePath::of_edges(stretch, {a, b}, {c, d});
  }
};

inline RigidQuery random_rigid_query(Random& random, RigidQuery::Kind kind) {
  const Pose from = random.pose(2e-3);
  const Pose to{from.p + 2e-3 * random.direction(),
                from_rotation_vector(random.uniform(0, 1) * random.direction()) * from.q};
  RigidQuery query{kind, motion_between(from, to, 1e-3 * random.direction()), {}};
  for (Vec3& v : query.corners) v = random.in_box({-2e-3, -2e-3, -2e-3}, {2e-3, 2e-3, 2e-3});
  return query;
}

/// Whether the features pass through each other, well inside both, before a time: signed volumes
/// that change sign between dense samples.
inline bool pass_before(const RigidQuery& query, double end) {
  const auto& p = query.corners;
  const bool is_edges = query.kind == RigidQuery::kEdges;
  const bool is_face_moved = query.kind == RigidQuery::kFaceVertex;
  constexpr int kSteps = 200;
  double last = 0;
  for (int step = 0; step <= kSteps; ++step) {
    const Pose X = query.motion.at(end * step / kSteps * (1 - 1e-6));
    const auto at = [&](size_t i) {
      const bool is_tool = is_edges ? i < 2 : (i == 0) != is_face_moved;
      return is_tool ? X * p[i] : p[i];
    };
    const Vec3 a = at(0), b = at(1), c = at(2), d = at(3);
    const double volume =
        is_edges ? dot(c - a, cross(b - a, d - c)) : dot(a - b, cross(c - b, d - b));
    const bool passed = step > 0 && (volume > 0) != (last > 0);
    last = volume;
    if (!passed) continue;
    // in the plane, or on both lines: within both features?
    const Vec3 e = is_edges ? b - a : c - b, f = is_edges ? d - c : d - b, n = cross(e, f),
               r = is_edges ? c - a : a - b;
    const double u = dot(cross(r, f), n) / dot(n, n);
    const double v = dot(is_edges ? cross(r, e) : cross(e, r), n) / dot(n, n);
    if (is_edges ? u > 0.01 && u < 0.99 && v > 0.01 && v < 0.99
                 : u > 0.01 && v > 0.01 && u + v < 0.98) {
      return true;
    }
  }
  return false;
}

/// A method never answers later than a meeting that was made: `ask` gives the answer for the
/// corners of a vertex and a face, or of two edges.
template <typename Ask>
void check_made_meetings(size_t n, Ask ask) {
  Random random(4);
  double latest = -1, earliest = 0;
  for (size_t k = 0; k < n; ++k) {
    const MadeMeeting made = made_meeting(random, k % 2 == 0);
    const std::optional<SweptMeeting> hit = ask(made.corners, k % 2 == 0);
    REQUIRE(hit);
    latest = std::max(latest, hit->time - made.time);
    // there may have been an earlier contact, of two edges or a face that turns
    earliest += hit->time < made.time - 1e-3 ? 1 : 0;
  }
  CHECK(latest <= 1e-12);
  CHECK(earliest < 0.02 * static_cast<double>(n));
}

/// The same for rigid motions, against dense samples; all of its meetings are proven.
template <typename Ask>
void check_rigid_queries(size_t n, Ask ask) {
  Random random(5);
  size_t meetings = 0, unproven = 0;
  for (size_t k = 0; k < n; ++k) {
    const RigidQuery query = random_rigid_query(random, static_cast<RigidQuery::Kind>(k % 3));
    const std::optional<SweptMeeting> hit = ask(query, stretch_of(query.motion, 0, 1, 4e-3));
    meetings += hit ? 1 : 0;
    unproven += hit && !hit->is_proven ? 1 : 0;
    REQUIRE_FALSE(pass_before(query, hit ? hit->time : 1));
  }
  CAPTURE(meetings, unproven);
  CHECK(meetings > n / 50);
  CHECK(unproven == 0);
}

inline void check_unproven_at_once(const std::optional<SweptMeeting>& hit) {
  REQUIRE(hit);
  CHECK(hit->time == 0);
  CHECK_FALSE(hit->is_proven);
}

/// A vertex that is not finite meets a face at once, unproven: `ask` gives the answer.
template <typename Ask>
void check_not_finite(Ask ask) {
  const std::array<SweptPoint, 3> face{
      {{{-1, -1, 0}, {-1, -1, 0}}, {{2, -1, 0}, {2, -1, 0}}, {{-1, 2, 0}, {-1, 2, 0}}}};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
    check_unproven_at_once(ask(SweptPoint{{0, 0, 1}, {0, 0, bad}}, face));
    check_unproven_at_once(ask(SweptPoint{{bad, 0, 1}, {0, 0, -1}}, face));
  }
}

}  // namespace haptic::test

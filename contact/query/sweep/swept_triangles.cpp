// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/swept_triangles.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Returns true if a direction separates the swept triangle from the fixed one.
bool is_apart(const Vec3& axis, const SweptTriangle& tool, const Corners& face_O) {
  const auto along = [&](const Corners& c) {
    return std::array{dot(axis, c[0]), dot(axis, c[1]), dot(axis, c[2])};
  };
  const auto least = [](const std::array<double, 3>& d) {
    return std::min(std::min(d[0], d[1]), d[2]);
  };
  const auto most = [](const std::array<double, 3>& d) {
    return std::max(std::max(d[0], d[1]), d[2]);
  };
  const auto from = along(tool.from_O), to = along(tool.to_O), face = along(face_O);
  const double off = tool.off * (std::fabs(axis.x) + std::fabs(axis.y) + std::fabs(axis.z));
  return std::min(least(from), least(to)) - most(face) > off ||
         least(face) - std::max(most(from), most(to)) > off;
}

}  // namespace

SweptTriangle swept(const Corners& corners_T, const MotionStretch& stretch) {
  HAPTIC_ASSERT(stretch.from <= stretch.to);
  SweptTriangle triangle{corners_T, {}, {}, 0};
  double furthest = 0;
  for (size_t i = 0; i < 3; ++i) {
    triangle.from_O[i] = stretch.from_OT * corners_T[i];
    triangle.to_O[i] = stretch.to_OT * corners_T[i];
    furthest = std::max(furthest, norm_squared(corners_T[i] - stretch.motion.centre_T));
  }
  triangle.off = stretch.rounding +
                 off_the_chord(stretch.motion, std::sqrt(furthest), stretch.to - stretch.from);
  return triangle;
}

bool may_meet(const SweptTriangle& tool, const Corners& face_O) {
  const Vec3 normal_O = cross(face_O[1] - face_O[0], face_O[2] - face_O[0]);
  if (is_apart(normal_O, tool, face_O)) return false;
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    if (is_apart(axis, tool, face_O)) return false;
  }
  const Vec3 normal_tool = cross(tool.from_O[1] - tool.from_O[0], tool.from_O[2] - tool.from_O[0]);
  return !is_apart(normal_tool, tool, face_O);
}

std::optional<SweptMeeting> first_meeting(const MotionStretch& stretch, const SweptTriangle& tool,
                                          const Corners& face_O, const AskedFeatures& asked,
                                          double tolerance) {
  std::optional<SweptMeeting> first;
  const auto take = [&](const FeaturePath& path) {
    const std::optional<SweptMeeting> meeting = first_meeting(path, tolerance);
    if (meeting && (!first || meeting->time < first->time)) first = meeting;
  };
  const Corners& p_T = tool.corners_T;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<size_t>(i), next = static_cast<size_t>((i + 1) % 3);
    if (asked.tool.has_vertex(asked.triangle_T, i)) {
      take(FeaturePath::of_vertex_and_face(stretch, p_T[at], face_O));
    }
    if (asked.object.has_vertex(asked.triangle_O, i)) {
      take(FeaturePath::of_face_and_vertex(stretch, p_T, face_O[at]));
    }
    if (!asked.tool.has_edge(asked.triangle_T, i)) continue;
    for (int j = 0; j < 3; ++j) {
      if (!asked.object.has_edge(asked.triangle_O, j)) continue;
      const auto from = static_cast<size_t>(j), to = static_cast<size_t>((j + 1) % 3);
      take(FeaturePath::of_edges(stretch, {p_T[at], p_T[next]}, {face_O[from], face_O[to]}));
    }
  }
  return first;
}

}  // namespace haptic

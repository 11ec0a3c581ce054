// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/swept_pair.h"

#include <algorithm>
#include <cmath>

#include "contact/query/sweep/feature_advance.h"

namespace haptic {
namespace {

struct Range {
  double least, most;
  double sum = 0;  // not finite if any coordinate is not
};

/// Range of a feature's coordinates along one axis, over the whole motion.
template <size_t N>
Range range_of(const std::array<SweptPoint, N>& corners, double Vec3::*axis) {
  Range range{corners[0].from.*axis, corners[0].from.*axis};
  for (const SweptPoint& corner : corners) {
    for (const double place : {corner.from.*axis, corner.to.*axis}) {
      range.sum += place;
      range.least = std::min(range.least, place);
      range.most = std::max(range.most, place);
    }
  }
  return range;
}

/// Returns true if a coordinate axis separates the two features along the whole motion; exact.
template <size_t N, size_t M>
bool are_beside(const std::array<SweptPoint, N>& one, const std::array<SweptPoint, M>& other) {
  bool is_beside = false;
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    const Range a = range_of(one, axis), b = range_of(other, axis);
    if (!std::isfinite(a.sum + b.sum)) return false;
    is_beside |= a.least > b.most || a.most < b.least;
  }
  return is_beside;
}

}  // namespace

std::optional<SweptMeeting> first_meeting(const FeaturePath& path, double tolerance) {
  if (!path.is_finite()) return SweptMeeting{path.begin(), false};
  const Advance advanced = advance(path, tolerance);
  if (advanced.end == Advance::End::kApart) return std::nullopt;
  return SweptMeeting{advanced.time, advanced.end == Advance::End::kNear};
}

std::optional<SweptMeeting> vertex_face_meeting(const SweptPoint& vertex,
                                                const std::array<SweptPoint, 3>& face,
                                                double tolerance) {
  if (are_beside(std::array{vertex}, face)) return std::nullopt;
  return first_meeting(FeaturePath::of_vertex_and_face(vertex, face), tolerance);
}

std::optional<SweptMeeting> edge_edge_meeting(const std::array<SweptPoint, 2>& a,
                                              const std::array<SweptPoint, 2>& b,
                                              double tolerance) {
  if (are_beside(a, b)) return std::nullopt;
  return first_meeting(FeaturePath::of_edges(a, b), tolerance);
}

}  // namespace haptic

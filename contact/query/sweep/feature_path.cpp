// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/sweep/feature_path.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Error of a difference of coordinates, and of the interpolation between two of them: relative to
/// the difference, not to the coordinates.
Vec3 error_of(const Vec3& a, const Vec3& b) {
  return 8 * kHalfStep *
         Vec3{std::max(std::fabs(a.x), std::fabs(b.x)), std::max(std::fabs(a.y), std::fabs(b.y)),
              std::max(std::fabs(a.z), std::fabs(b.z))};
}

double squared_lever(const MotionStretch& stretch, const Vec3& p_T) {
  return norm_squared(p_T - stretch.motion.centre_T);
}

}  // namespace

FeaturePath::FeaturePath(const Slice& from, const Slice& to, bool is_triangle)
    : from_(from),
      to_(to),
      errors_{error_of(from.base, to.base), error_of(from.e, to.e), error_of(from.f, to.f)},
      is_triangle_(is_triangle) {}

FeaturePath::FeaturePath(const Turning& turning, bool is_triangle, double furthest_squared)
    : begin_(turning.stretch->from),
      end_(turning.stretch->to),
      turning_(turning),
      furthest_(std::sqrt(furthest_squared)),
      is_triangle_(is_triangle) {
  HAPTIC_ASSERT(furthest_squared >= 0);
  from_ = seen_from(turning.stretch->from_OT);
  to_ = seen_from(turning.stretch->to_OT);
  const Vec3 off = turning.stretch->rounding * Vec3{1, 1, 1};
  errors_ = {off, off, off};
}

Slice FeaturePath::seen_from(const Pose& X_OT) const {
  const Turning& m = turning_;
  return {m.sign * (X_OT * m.point_T) + m.base_O, rotate(X_OT.q, m.e_T) + m.e_O,
          rotate(X_OT.q, m.f_T) + m.f_O};
}

Slice FeaturePath::at(double t) const {
  if (t == begin_) return from_;
  if (t == end_) return to_;
  if (turning_.stretch != nullptr) return seen_from(turning_.stretch->motion.at(t));
  const auto between = [t](const Vec3& a, const Vec3& b) { return (1 - t) * a + t * b; };
  return {between(from_.base, to_.base), between(from_.e, to_.e), between(from_.f, to_.f)};
}

bool FeaturePath::is_finite() const {
  const auto is_slice_finite = [](const Slice& s) {
    return haptic::is_finite(s.base) && haptic::is_finite(s.e) && haptic::is_finite(s.f);
  };
  return is_slice_finite(from_) && is_slice_finite(to_);
}

double FeaturePath::deviation(double time) const {
  return turning_.stretch != nullptr ? off_the_chord(turning_.stretch->motion, furthest_, time) : 0;
}

FeaturePath FeaturePath::of_vertex_and_face(const SweptPoint& vertex,
                                            const std::array<SweptPoint, 3>& face) {
  const auto& [a, b, c] = face;
  return {{vertex.from - a.from, b.from - a.from, c.from - a.from},
          {vertex.to - a.to, b.to - a.to, c.to - a.to},
          true};
}

FeaturePath FeaturePath::of_edges(const std::array<SweptPoint, 2>& a,
                                  const std::array<SweptPoint, 2>& b) {
  return {{a[0].from - b[0].from, a[0].from - a[1].from, b[1].from - b[0].from},
          {a[0].to - b[0].to, a[0].to - a[1].to, b[1].to - b[0].to},
          false};
}

FeaturePath FeaturePath::of_vertex_and_face(const MotionStretch& stretch, const Vec3& vertex_T,
                                            const std::array<Vec3, 3>& face_O) {
  const auto& [a, b, c] = face_O;
  return {
      {&stretch, vertex_T, {}, {}, 1, -a, b - a, c - a}, true, squared_lever(stretch, vertex_T)};
}

FeaturePath FeaturePath::of_face_and_vertex(const MotionStretch& stretch,
                                            const std::array<Vec3, 3>& face_T,
                                            const Vec3& vertex_O) {
  const auto& [a, b, c] = face_T;
  const double furthest =
      std::max({squared_lever(stretch, a), squared_lever(stretch, b), squared_lever(stretch, c)});
  return {{&stretch, a, b - a, c - a, -1, vertex_O, {}, {}}, true, furthest};
}

FeaturePath FeaturePath::of_edges(const MotionStretch& stretch, const std::array<Vec3, 2>& edge_T,
                                  const std::array<Vec3, 2>& edge_O) {
  const double furthest =
      std::max(squared_lever(stretch, edge_T[0]), squared_lever(stretch, edge_T[1]));
  return {
      {&stretch, edge_T[0], edge_T[0] - edge_T[1], {}, 1, -edge_O[0], {}, edge_O[1] - edge_O[0]},
      false,
      furthest};
}

}  // namespace haptic

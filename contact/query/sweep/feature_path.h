// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "contact/query/box/rigid_motion.h"

namespace haptic {

inline constexpr double kHalfStep = 0x1p-53;  // what one rounding adds, in parts

/// A corner that goes straight from one place to another in a time from 0 to 1, all in one frame.
struct SweptPoint {
  Vec3 from, to;
};

/// Two features at a time: F(u, v) = base − u e − v f is where one is seen from the other, u, v ≥ 0
/// and u + v ≤ 1 for a vertex and a face, u, v ≤ 1 for two edges. They meet where F = 0.
struct Slice {
  Vec3 base, e, f;
};

/// How far base, e and f may be off along each axis where they are computed [m].
struct SliceErrors {
  Vec3 base, e, f;
};

/// Two features along a motion.
class FeaturePath {
 public:
  /// Corners that go straight: base = p − a, e = b − a, f = c − a of a vertex and a face.
  static FeaturePath of_vertex_and_face(const SweptPoint& vertex,
                                        const std::array<SweptPoint, 3>& face);
  /// base = a0 − b0, e = a0 − a1, f = b1 − b0 of two edges.
  static FeaturePath of_edges(const std::array<SweptPoint, 2>& a,
                              const std::array<SweptPoint, 2>& b);
  /// The same of a tool that moves past still features; the stretch must outlive the path.
  static FeaturePath of_vertex_and_face(const MotionStretch& stretch, const Vec3& vertex_T,
                                        const std::array<Vec3, 3>& face_O);
  static FeaturePath of_face_and_vertex(const MotionStretch& stretch,
                                        const std::array<Vec3, 3>& face_T, const Vec3& vertex_O);
  static FeaturePath of_edges(const MotionStretch& stretch, const std::array<Vec3, 2>& edge_T,
                              const std::array<Vec3, 2>& edge_O);

  Slice at(double t) const;
  /// Between two times so far apart a corner is off the straight way between its places by no more.
  double deviation(double time) const;

  double begin() const { return begin_; }
  double end() const { return end_; }
  const Slice& first() const { return from_; }
  const Slice& last() const { return to_; }
  const SliceErrors& errors() const { return errors_; }
  bool is_triangle() const { return is_triangle_; }

 private:
  /// What of a slice moves with the tool, and what stays.
  struct Turning {
    const MotionStretch* stretch;
    Vec3 point_T, e_T, f_T;
    double sign;  // of the point in the base
    Vec3 base_O, e_O, f_O;
  };
  FeaturePath(const Slice& from, const Slice& to, bool is_triangle);
  FeaturePath(const Turning& turning, bool is_triangle, double furthest_squared);
  Slice seen_from(const Pose& X_OT) const;

  Slice from_, to_;
  double begin_ = 0, end_ = 1;
  Turning turning_{};
  double furthest_ = 0;  // corner from the centre of the turn [m]
  SliceErrors errors_;
  bool is_triangle_;
};

}  // namespace haptic

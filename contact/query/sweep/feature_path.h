// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "contact/query/box/rigid_motion.h"

namespace haptic {

inline constexpr double kHalfStep = 0x1p-53;  // relative error of one rounding

/// A point that moves linearly over time 0 to 1.
struct SweptPoint {
  Vec3 from, to;
};

/// Two features at one time: their difference F(u, v) = base − u e − v f, with u, v ≥ 0 and u + v ≤
/// 1 for a vertex and a face, 0 ≤ u, v ≤ 1 for two edges. They meet where F = 0.
struct Slice {
  Vec3 base, e, f;
};

/// Bounds of the rounding errors of base, e and f, per axis [m].
struct SliceErrors {
  Vec3 base, e, f;
};

class FeaturePath {
 public:
  /// For points that move linearly. A vertex p and a face a, b, c: base = p − a, e = b − a, f = c −
  /// a.
  static FeaturePath of_vertex_and_face(const SweptPoint& vertex,
                                        const std::array<SweptPoint, 3>& face);
  /// Two edges: base = a0 − b0, e = a0 − a1, f = b1 − b0.
  static FeaturePath of_edges(const std::array<SweptPoint, 2>& a,
                              const std::array<SweptPoint, 2>& b);
  /// Paths of a rigid tool that moves past fixed features; the stretch must outlive the path.
  static FeaturePath of_vertex_and_face(const MotionStretch& stretch, const Vec3& vertex_T,
                                        const std::array<Vec3, 3>& face_O);
  static FeaturePath of_face_and_vertex(const MotionStretch& stretch,
                                        const std::array<Vec3, 3>& face_T, const Vec3& vertex_O);
  static FeaturePath of_edges(const MotionStretch& stretch, const std::array<Vec3, 2>& edge_T,
                              const std::array<Vec3, 2>& edge_O);

  Slice at(double t) const;
  /// Deviation of a corner from the straight line between its places at two times this far apart,
  /// at most [m].
  double deviation(double time) const;

  double begin() const { return begin_; }
  double end() const { return end_; }
  const Slice& first() const { return from_; }
  const Slice& last() const { return to_; }
  const SliceErrors& errors() const { return errors_; }
  bool is_triangle() const { return is_triangle_; }
  bool is_finite() const;

 private:
  /// The parts of a slice that move with the tool, and those that are fixed.
  struct Turning {
    const MotionStretch* stretch;
    Vec3 point_T, e_T, f_T;
    double sign;  // of the point within base
    Vec3 base_O, e_O, f_O;
  };
  FeaturePath(const Slice& from, const Slice& to, bool is_triangle);
  FeaturePath(const Turning& turning, bool is_triangle, double furthest_squared);
  Slice seen_from(const Pose& X_OT) const;

  Slice from_, to_;
  double begin_ = 0, end_ = 1;
  Turning turning_{};
  double furthest_ = 0;  // largest distance of a corner from the centre of rotation [m]
  SliceErrors errors_;
  bool is_triangle_;
};

}  // namespace haptic

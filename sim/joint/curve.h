// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

#include "proto/math/vec3.h"
#include "sim/joint/spline.h"

namespace haptic {

/// A way in space by its length.
struct Curve {
  std::array<Spline, 3> by_length;
  double length = 0;  // [m]
};

/// Natural spline through two points or more, by the length of the chords; its length is measured
/// along chords sixteen times finer, which for ways that bend by a radian between two points is
/// right to 1e-4.
Curve build_curve(std::span<const Vec3> points);

struct CurvePoint {
  Vec3 p;
  Vec3 tangent;    // unit
  Vec3 curvature;  // derivative of the tangent by length [1/m]
};

/// Beyond its ends a curve goes on straight.
CurvePoint curve_at(const Curve& curve, double length);

/// Length at the point of the curve that is nearest to p, sought from `near` on by Newton's method.
double nearest_length(const Curve& curve, const Vec3& p, double near);

}  // namespace haptic

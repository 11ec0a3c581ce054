// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "proto/math/vec3.h"

namespace haptic {

/// Sign of (a − d)·((b − d) × (c − d)): +1 if d lies behind the plane of a, b, c, seen
/// counter-clockwise from in front; 0 on it. Exact for the doubles given: a floating-point filter,
/// then expansion arithmetic (Shewchuk 1997). Coordinates must be finite, and zero or between 1e-70
/// and 1e70 in magnitude.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

using Point2 = std::array<double, 2>;

/// Sign of (b − a) × (c − a) in the plane: +1 if a, b, c turn counter-clockwise. Exact as above.
int orientation(const Point2& a, const Point2& b, const Point2& c);

}  // namespace haptic

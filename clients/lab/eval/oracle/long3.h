// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "clients/lab/support/vector3.h"

namespace haptic {

/// Extended precision: an oracle's rounding errors are a thousandth of those it checks.
using Long3 = Vector3<long double>;

inline Vec3 rounded(const Long3& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
inline long double norm(const Long3& a) {
  return std::sqrt(dot(a, a));
}
/// Zero if a is zero.
inline Long3 normalized(const Long3& a) {
  const long double length = norm(a);
  return length > 0 ? (1 / length) * a : Long3{};
}

}  // namespace haptic

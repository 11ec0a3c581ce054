// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "proto/math/vec3.h"

namespace haptic {

/// Extended precision: an oracle's rounding errors are a thousandth of those it checks.
struct Long3 {
  long double x = 0, y = 0, z = 0;
};

inline Long3 widened(const Vec3& v) {
  return {v.x, v.y, v.z};
}
inline Vec3 rounded(const Long3& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}
inline Long3 operator+(const Long3& a, const Long3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Long3 operator-(const Long3& a, const Long3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Long3 operator*(long double s, const Long3& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline long double dot(const Long3& a, const Long3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Long3 cross(const Long3& a, const Long3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
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

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <type_traits>

#include "proto/math/vec3.h"

namespace haptic {

/// A vector of numbers other than double: of extended precision, or of intervals.
template <class T>
struct Vector3 {
  T x{}, y{}, z{};
};

template <class T>
constexpr Vector3<T> widened(const Vec3& v) {
  return {v.x, v.y, v.z};
}
template <class T>
constexpr Vector3<T> operator+(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vector3<T> operator-(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vector3<T> operator*(const std::type_identity_t<T>& s, const Vector3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
constexpr T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace haptic

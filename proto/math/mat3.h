// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/math/vec3.h"

namespace haptic {

/// 3×3 matrix, stored by rows.
struct Mat3 {
  Vec3 row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  constexpr Vec3 column(int i) const { return {row[0][i], row[1][i], row[2][i]}; }
  constexpr bool operator==(const Mat3&) const = default;
};

constexpr Mat3 from_columns(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}}};
}
constexpr Mat3 transpose(const Mat3& m) {
  return {{m.column(0), m.column(1), m.column(2)}};
}
constexpr Vec3 operator*(const Mat3& m, const Vec3& a) {
  return {dot(m.row[0], a), dot(m.row[1], a), dot(m.row[2], a)};
}
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
  return from_columns(a * b.column(0), a * b.column(1), a * b.column(2));
}

constexpr Mat3 operator+(const Mat3& a, const Mat3& b) {
  return {{a.row[0] + b.row[0], a.row[1] + b.row[1], a.row[2] + b.row[2]}};
}
constexpr Mat3 operator*(double s, const Mat3& m) {
  return {{s * m.row[0], s * m.row[1], s * m.row[2]}};
}
/// [a]×: skew(a) b = a × b.
constexpr Mat3 skew(const Vec3& a) {
  return {{{0, -a.z, a.y}, {a.z, 0, -a.x}, {-a.y, a.x, 0}}};
}

}  // namespace haptic

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "proto/math/assert.h"
#include "proto/math/pose.h"

namespace haptic {

/// 6×6 matrix from a small motion (translation, rotation vector) or a twist to a wrench; row major,
/// force before torque, in one frame about one point. The layout of ContactSet::K and ::B.
struct Mat6 {
  std::array<double, 36> a{};

  constexpr double& operator()(size_t row, size_t column) { return a[6 * row + column]; }
  constexpr double operator()(size_t row, size_t column) const { return a[6 * row + column]; }
  constexpr Mat6& operator+=(const Mat6& b) {
    for (size_t i = 0; i < 36; ++i) a[i] += b.a[i];
    return *this;
  }
  constexpr bool operator==(const Mat6&) const = default;
};

inline bool all_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
}

constexpr Mat6 operator*(double s, const Mat6& m) {
  Mat6 scaled;
  for (size_t i = 0; i < 36; ++i) scaled.a[i] = s * m.a[i];
  return scaled;
}

constexpr Mat6 operator*(const Mat6& a, const Mat6& b) {
  Mat6 c;
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) {
      for (size_t k = 0; k < 6; ++k) c(i, j) += a(i, k) * b(k, j);
    }
  }
  return c;
}

constexpr Mat6 transpose(const Mat6& m) {
  Mat6 t;
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) t(i, j) = m(j, i);
  }
  return t;
}

constexpr std::array<double, 6> components(const Vec3& first, const Vec3& second) {
  return {first.x, first.y, first.z, second.x, second.y, second.z};
}

constexpr std::array<double, 6> operator*(const Mat6& m, const std::array<double, 6>& x) {
  std::array<double, 6> y{};
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) y[i] += m(i, j) * x[j];
  }
  return y;
}

constexpr Wrench operator*(const Mat6& m, const Twist& motion) {
  const std::array<double, 6> y = m * components(motion.v, motion.w);
  return {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
}

/// Adds F wᵀ: the wrench F per unit of w·motion.
constexpr void add_outer(Mat6& m, const Wrench& F, const Twist& per_motion) {
  const std::array<double, 6> rows = components(F.f, F.t);
  const std::array<double, 6> columns = components(per_motion.v, per_motion.w);
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j < 6; ++j) m(i, j) += rows[i] * columns[j];
  }
}

/// Adds a 3×3 block; row and column are 0 or 3.
constexpr void add_block(Mat6& m, size_t row, size_t column, const Mat3& block) {
  HAPTIC_ASSERT((row == 0 || row == 3) && (column == 0 || column == 3));
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      m(row + i, column + j) += block.row[i][static_cast<int>(j)];
    }
  }
}

/// R M Rᵀ, block by block: the map in axes rotated by R.
constexpr Mat6 rotated(const Mat3& R, const Mat6& m) {
  Mat6 out;
  for (size_t row = 0; row < 6; row += 3) {
    for (size_t column = 0; column < 6; column += 3) {
      Mat3 block;
      for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) block.row[i][static_cast<int>(j)] = m(row + i, column + j);
      }
      add_block(out, row, column, R * block * transpose(R));
    }
  }
  return out;
}

/// Work of a wrench on a motion [J], or power on a twist [W].
constexpr double dot(const Wrench& F, const Twist& motion) {
  return dot(F.f, motion.v) + dot(F.t, motion.w);
}

/// A Jacobian row times a motion.
constexpr double dot(const Twist& row, const Twist& motion) {
  return dot(row.v, motion.v) + dot(row.w, motion.w);
}

/// Solves A x = b by LU with partial pivoting. False, with x zero, if A is singular to rounding or
/// something is not finite. No allocation.
bool solve(const Mat6& A, const Wrench& b, Twist& x);

}  // namespace haptic

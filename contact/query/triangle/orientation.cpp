// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/triangle/orientation.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kHalfUlp = 0x1p-53;  // relative error of one rounding
// error bounds of the determinants, relative to the sum of the magnitudes (Shewchuk 1997)
constexpr double kSpatialBound = (7 + 56 * kHalfUlp) * kHalfUlp;
constexpr double kPlanarBound = (3 + 16 * kHalfUlp) * kHalfUlp;

int sign(double a) {
  return a > 0 ? 1 : a < 0 ? -1 : 0;
}

/// An exact sum of doubles: non-overlapping components of increasing magnitude (Shewchuk 1997,
/// GROW-EXPANSION with zeros eliminated). Never more components than were added.
struct Expansion {
  std::array<double, 96> part;
  size_t n = 0;

  void add(double value) {
    HAPTIC_ASSERT(n < part.size());
    size_t kept = 0;
    for (size_t i = 0; i < n; ++i) {
      const double sum = value + part[i], of_part = sum - value;
      const double rest = (value - (sum - of_part)) + (part[i] - of_part);
      if (rest != 0) part[kept++] = rest;
      value = sum;
    }
    if (value != 0) part[kept++] = value;
    n = kept;
  }
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  void add_product(double a, double b, double c) {
    const double product = a * b;
    add_product(std::fma(a, b, -product), c);
    add_product(product, c);
  }
  /// ±a·(b × c)
  void add_triple(double s, const Vec3& a, const Vec3& b, const Vec3& c) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      add_product(s * a[i], b[j], c[k]);
      add_product(-s * a[i], b[k], c[j]);
    }
  }
  /// The last component exceeds the sum of all others.
  int sign_of() const { return n > 0 ? sign(part[n - 1]) : 0; }
};

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Expansion sum;
  sum.add_triple(1, a, b, c);
  sum.add_triple(-1, d, b, c);
  sum.add_triple(-1, a, d, c);
  sum.add_triple(-1, a, b, d);
  return sum.sign_of();
}

int exact_orientation(const Point2& a, const Point2& b, const Point2& c) {
  Expansion sum;
  for (const auto& [p, q] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
    sum.add_product(p[0], q[1]);
    sum.add_product(-p[1], q[0]);
  }
  return sum.sign_of();
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 p = a - d, q = b - d, r = c - d;
  double determinant = 0, size = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double plus = q[j] * r[k], minus = q[k] * r[j];
    determinant += p[i] * (plus - minus);
    size += std::fabs(p[i]) * (std::fabs(plus) + std::fabs(minus));
  }
  const double bound = kSpatialBound * size;
  if (determinant > bound || -determinant > bound) return sign(determinant);
  return exact_orientation(a, b, c, d);
}

int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const double plus = (b[0] - a[0]) * (c[1] - a[1]), minus = (b[1] - a[1]) * (c[0] - a[0]);
  const double determinant = plus - minus;
  const double bound = kPlanarBound * (std::fabs(plus) + std::fabs(minus));
  if (determinant > bound || -determinant > bound) return sign(determinant);
  return exact_orientation(a, b, c);
}

}  // namespace haptic

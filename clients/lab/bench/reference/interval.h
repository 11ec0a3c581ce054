// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "clients/lab/support/vector3.h"

namespace haptic {

/// All reals from lo to hi. The result of every operation contains the exact result for any choice
/// from the operands, unless something overflows: bounds are rounded outward, by less than three
/// ulps.
struct Interval {
  double lo = 0, hi = 0;

  constexpr Interval() = default;
  constexpr Interval(double both) : lo(both), hi(both) {}  // NOLINT: a number is an interval
  constexpr Interval(double low, double high) : lo(low), hi(high) {}

  constexpr bool contains(double v) const { return lo <= v && v <= hi; }
  constexpr double width() const { return hi - lo; }
  constexpr bool operator==(const Interval&) const = default;
};

/// Lower and upper bound of a value rounded to nearest: its error is at most |v|/2⁵³, or the
/// smallest denormal.
constexpr double rounded_down(double v) {
  return v - ((v < 0 ? -v : v) * 0x1p-52 + std::numeric_limits<double>::denorm_min());
}
constexpr double rounded_up(double v) {
  return v + ((v < 0 ? -v : v) * 0x1p-52 + std::numeric_limits<double>::denorm_min());
}

constexpr Interval outward(double lo, double hi) {
  return {rounded_down(lo), rounded_up(hi)};
}
constexpr Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

constexpr Interval operator-(const Interval& a) {
  return {-a.hi, -a.lo};
}
constexpr Interval operator+(const Interval& a, const Interval& b) {
  return outward(a.lo + b.lo, a.hi + b.hi);
}
constexpr Interval operator-(const Interval& a, const Interval& b) {
  return outward(a.lo - b.hi, a.hi - b.lo);
}
constexpr Interval operator*(const Interval& a, const Interval& b) {
  const double ll = a.lo * b.lo, lh = a.lo * b.hi, hl = a.hi * b.lo, hh = a.hi * b.hi;
  return outward(std::min(std::min(ll, lh), std::min(hl, hh)),
                 std::max(std::max(ll, lh), std::max(hl, hh)));
}

/// Tighter than the product: [−1, 2]² = [0, 4], not [−2, 4].
constexpr Interval squared(const Interval& a) {
  const double ll = a.lo * a.lo, hh = a.hi * a.hi;
  const bool has_zero = a.contains(0);
  return {has_zero ? 0 : std::max(rounded_down(std::min(ll, hh)), 0.0),
          rounded_up(std::max(ll, hh))};
}
constexpr Interval magnitude(const Interval& a) {
  if (a.lo >= 0) return a;
  if (a.hi <= 0) return -a;
  return {0, std::max(-a.lo, a.hi)};
}

/// Range over all angles of the interval [rad]: the values at its ends, and ±1 if it contains such
/// an extremum.
Interval cos(const Interval& angle);
Interval sin(const Interval& angle);

using Interval3 = Vector3<Interval>;

}  // namespace haptic

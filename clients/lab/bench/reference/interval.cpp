// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/reference/interval.h"

#include <numbers>

namespace haptic {
namespace {

// [rad]; beyond, multiples of π cannot be located in double
constexpr double kMostAngle = 1e6;
constexpr double kUnsure = 1e-9;  // uncertainty of a multiple of π at kMostAngle [π]

/// Returns true if the interval contains k π for some k = first + 2 n; rounding may add cases,
/// never lose one.
bool may_hold(const Interval& angle, double first) {
  const double low = (angle.lo / std::numbers::pi - first) / 2 - kUnsure,
               high = (angle.hi / std::numbers::pi - first) / 2 + kUnsure;
  return std::floor(high) >= std::ceil(low);
}

/// The library is off by less than an ulp, so the bounds are rounded outward twice.
Interval between_ends(double a, double b) {
  return {std::max(rounded_down(rounded_down(std::min(a, b))), -1.0),
          std::min(rounded_up(rounded_up(std::max(a, b))), 1.0)};
}

bool is_any_angle(const Interval& angle) {
  return !(magnitude(angle).hi < kMostAngle) || angle.width() >= 2 * std::numbers::pi;
}

}  // namespace

Interval cos(const Interval& angle) {
  if (is_any_angle(angle)) return {-1, 1};
  Interval range = between_ends(std::cos(angle.lo), std::cos(angle.hi));
  if (may_hold(angle, 0)) range.hi = 1;
  if (may_hold(angle, 1)) range.lo = -1;
  return range;
}

Interval sin(const Interval& angle) {
  if (is_any_angle(angle)) return {-1, 1};
  Interval range = between_ends(std::sin(angle.lo), std::sin(angle.hi));
  if (may_hold(angle, 0.5)) range.hi = 1;
  if (may_hold(angle, 1.5)) range.lo = -1;
  return range;
}

}  // namespace haptic

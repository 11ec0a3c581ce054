// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/portable_turn.h"
#include "proto/math/units.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace haptic {
namespace {

/// Coefficients (−1)ⁿ/(2n+1)! of sin x / x in x².
constexpr auto kSinSeries = [] {
  std::array<double, 10> series{1};
  for (size_t n = 1; n < series.size(); ++n) {
    series[n] = -series[n - 1] / static_cast<double>(2 * n * (2 * n + 1));
  }
  return series;
}();

/// Coefficients (−1)ⁿ/(2n+1) of atan x / x in x²: below tan(π/16) the rest is 1e-18.
constexpr auto kAtanSeries = [] {
  std::array<double, 12> series{};
  for (size_t n = 0; n < series.size(); ++n) {
    series[n] = (n % 2 == 0 ? 1.0 : -1.0) / static_cast<double>(2 * n + 1);
  }
  return series;
}();

template <size_t N>
double polynomial(const std::array<double, N>& series, double x) {
  double sum = 0;
  for (size_t n = N; n-- > 0;) sum = sum * x + series[n];
  return sum;
}

/// Below this the closed forms of the Jacobians cancel, and three terms of their series are exact
/// to 1e-13 [rad].
constexpr double kSmallTurn = 0.05;

}  // namespace

double portable_sin(double x) {
  double r = x - 2 * kPi * std::floor(x / (2 * kPi) + 0.5);
  if (r > kPi / 2) r = kPi - r;
  if (r < -kPi / 2) r = -kPi - r;
  return r * polynomial(kSinSeries, r * r);
}

double portable_cos(double x) {
  return portable_sin(x + kPi / 2);
}

Quat portable_turn(const Vec3& r) {
  const double half = norm(r) / 2;
  // sin(half)/half by its series, which needs no division
  const double s =
      half <= kPi / 2 ? polynomial(kSinSeries, half * half) / 2 : portable_sin(half) / (2 * half);
  return normalized(Quat{s * r.x, s * r.y, s * r.z, portable_cos(half)});
}

Vec3 portable_rotation_vector(const Quat& q) {
  const double sign = q.w < 0 ? -1 : 1;
  const double sine = norm(q.vector()), cosine = sign * q.w;
  const double length = std::sqrt(sine * sine + cosine * cosine);
  if (!(length > 0)) return {};
  // half the angle is φ = 8 atan(tan(φ/8)); each halving is tan(a/2) = tan a/(1 + √(1 + tan² a)),
  // kept as a share of the sine so that small turns lose nothing
  double share = 1 / (length + cosine);
  double tangent = sine * share;
  for (int i = 0; i < 2; ++i) {
    const double shrink = 1 / (1 + std::sqrt(1 + tangent * tangent));
    share *= shrink;
    tangent *= shrink;
  }
  return 16 * sign * share * polynomial(kAtanSeries, tangent * tangent) * q.vector();
}

double turn_curvature(const Vec3& turn) {
  const double squared = norm_squared(turn);
  if (squared < kSmallTurn * kSmallTurn) {
    return 1.0 / 12 + squared * (1.0 / 720 + squared / 30240);
  }
  const double half = std::sqrt(squared) / 2;
  return (1 - half * portable_cos(half) / portable_sin(half)) / squared;
}

Vec3 angular_velocity_of(const Vec3& turn, const Vec3& rate) {
  const double squared = norm_squared(turn);
  double a = 0.5 + squared * (-1.0 / 24 + squared / 720);
  double b = 1.0 / 6 + squared * (-1.0 / 120 + squared / 5040);
  if (squared >= kSmallTurn * kSmallTurn) {
    const double angle = std::sqrt(squared);
    a = (1 - portable_cos(angle)) / squared;
    b = (angle - portable_sin(angle)) / (squared * angle);
  }
  const Vec3 across = cross(turn, rate);
  return rate + a * across + b * cross(turn, across);
}

Vec3 rotation_vector_rate(const Vec3& turn, const Vec3& w) {
  const Vec3 across = cross(turn, w);
  return w - 0.5 * across + turn_curvature(turn) * cross(turn, across);
}

}  // namespace haptic

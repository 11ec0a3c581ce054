// SPDX-License-Identifier: Apache-2.0
#include "proto/math/motion_metric.h"

namespace haptic {
namespace {

constexpr double kSingular = 1e-14;  // smallest squared pivot relative to its diagonal element

/// Tᵀ x of a lower triangular T.
Vec6 multiply_transposed(const Mat6& T, const Vec6& x) {
  Vec6 out{};
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j <= i; ++j) out[j] += T(i, j) * x[i];
  }
  return out;
}

}  // namespace

MotionMetric factor_metric(const Mat6& M) {
  MotionMetric metric;
  Mat6& L = metric.L;
  for (size_t j = 0; j < 6; ++j) {
    for (size_t i = j; i < 6; ++i) {
      double sum = M(i, j);
      for (size_t k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      if (i > j) {
        L(i, j) = sum / L(j, j);
        continue;
      }
      // written so that NaN is rejected
      if (!(sum > kSingular * M(j, j)) || !std::isfinite(sum)) return {};
      L(j, j) = std::sqrt(sum);
    }
  }
  Mat6& inverse = metric.inverse_L;
  for (size_t j = 0; j < 6; ++j) {
    inverse(j, j) = 1 / L(j, j);
    for (size_t i = j + 1; i < 6; ++i) {
      double sum = 0;
      for (size_t k = j; k < i; ++k) sum -= L(i, k) * inverse(k, j);
      inverse(i, j) = sum / L(i, i);
    }
  }
  metric.valid = true;
  for (const double x : inverse.a) metric.valid = metric.valid && std::isfinite(x);
  return metric;
}

Vec6 whitened(const MotionMetric& metric, const Vec6& x) {
  Vec6 y{};
  for (size_t i = 0; i < 6; ++i) {
    for (size_t j = 0; j <= i; ++j) y[i] += metric.inverse_L(i, j) * x[j];
  }
  return y;
}

Vec6 coordinates(const MotionMetric& metric, const Twist& a) {
  return multiply_transposed(metric.L, components(a.v, a.w));
}

Twist motion_of(const MotionMetric& metric, const Vec6& y) {
  const Vec6 a = multiply_transposed(metric.inverse_L, y);
  return {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}};
}

Twist response(const MotionMetric& metric, const Wrench& F) {
  return motion_of(metric, whitened(metric, components(F.f, F.t)));
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/joint/spline.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {

Spline build_spline(std::vector<double> x, std::vector<double> y) {
  HAPTIC_ASSERT(x.size() >= 2 && x.size() == y.size());
  const size_t n = x.size();
  std::vector<double> second(n, 0.0), upper(n, 0.0);
  // the tridiagonal system of continuous first derivatives, by elimination
  for (size_t i = 1; i + 1 < n; ++i) {
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    HAPTIC_ASSERT(before > 0 && after > 0);
    const double bend = 6 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before);
    const double pivot = 2 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    second[i] = (bend - before * second[i - 1]) / pivot;
  }
  for (size_t i = n - 1; i-- > 1;) second[i] -= upper[i] * second[i + 1];
  return {std::move(x), std::move(y), std::move(second)};
}

SplineValue spline_at(const Spline& spline, double x) {
  const size_t n = spline.x.size();
  x = std::clamp(x, spline.x.front(), spline.x.back());
  const auto above = std::upper_bound(spline.x.begin() + 1, spline.x.end() - 1, x);
  const auto i = static_cast<size_t>(above - spline.x.begin()) - 1;
  HAPTIC_ASSERT(i + 1 < n);
  const double h = spline.x[i + 1] - spline.x[i];
  const double b = (x - spline.x[i]) / h, a = 1 - b;
  const double left = spline.second[i], right = spline.second[i + 1];
  SplineValue value;
  value.y = a * spline.y[i] + b * spline.y[i + 1] +
            h * h / 6 * ((a * a * a - a) * left + (b * b * b - b) * right);
  value.first = (spline.y[i + 1] - spline.y[i]) / h +
                h / 6 * ((3 * b * b - 1) * right - (3 * a * a - 1) * left);
  value.second = a * left + b * right;
  return value;
}

}  // namespace haptic

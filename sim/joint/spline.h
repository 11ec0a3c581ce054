// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace haptic {

/// Natural cubic spline: through all its points, twice continuously differentiable, second
/// derivative zero at both ends.
struct Spline {
  std::vector<double> x;       // ascending
  std::vector<double> y;       // at x
  std::vector<double> second;  // derivative at x
};

/// At least two points; x ascends.
Spline build_spline(std::vector<double> x, std::vector<double> y);

struct SplineValue {
  double y = 0, first = 0, second = 0;  // value and derivatives by x
};

/// At x, or at the end of the spline that is nearer.
SplineValue spline_at(const Spline& spline, double x);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/margin_curve.h"

#include <cmath>
#include <numbers>

namespace haptic {

std::vector<MarginPoint> margin_curve(const CoupledAxis& axis) {
  constexpr int kPoints = 400;
  // the lowest of the check are far below what a hand does
  constexpr double kShare = 1e-4;
  const double highest = margin_band().highest;
  std::vector<MarginPoint> out;
  for (int i = 0; i < kPoints; ++i) {
    const double omega_t = highest * std::pow(kShare, 1 - i / (kPoints - 1.0));
    out.push_back(
        {omega_t / (2 * std::numbers::pi * axis.period), two_port_margin_at(axis, omega_t)});
  }
  return out;
}

double largest_with_margin(CoupledAxis axis) {
  constexpr double kWithin = 1.001;
  const auto holds = [&axis](double stiffness) {
    axis.stiffness = stiffness;
    return stiffness < passive_stiffness(axis) && two_port_margin(axis) >= 0;
  };
  double high = passive_stiffness(axis), low = high;
  const double least = 1e-6 * high;
  if (!(high > 0)) return 0;
  do {
    low /= 2;
    if (low < least) return 0;
  } while (!holds(low));
  while (high > kWithin * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace haptic

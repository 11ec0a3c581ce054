// SPDX-License-Identifier: Apache-2.0
#include "proto/config/coupling_margin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptic {
namespace {

constexpr int kFrequencies = 4000;  // grid points, logarithmic up to half the sampling rate
constexpr double kLowest = 1e-6;    // lowest frequency, as a share of that

/// ω T of a grid point; at π, half the sampling rate, the hold vanishes.
double grid(int i) {
  return std::numbers::pi * std::pow(kLowest, 1 - static_cast<double>(i + 1) / (kFrequencies + 1));
}

}  // namespace

double two_port_margin_at(const CoupledAxis& axis, double omega_t) {
  const double hold = std::cos(0.5 * omega_t);
  const double device = axis.damping + axis.mass / axis.period * (1 - std::cos(omega_t));
  const double half = 0.5 * axis.stiffness * axis.period;
  const double real = axis.coupling_damping + half, imaginary = half / std::tan(0.5 * omega_t);
  const double size2 = real * real + imaginary * imaginary;
  const double compliance = size2 > 0 ? real / size2 : std::numeric_limits<double>::infinity();
  return hold + 2 * device * compliance / hold - 1;
}

double two_port_margin(const CoupledAxis& axis) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kFrequencies; ++i) least = std::min(least, two_port_margin_at(axis, grid(i)));
  return least;
}

MarginBand margin_band() {
  return {grid(0), grid(kFrequencies - 1)};
}

}  // namespace haptic

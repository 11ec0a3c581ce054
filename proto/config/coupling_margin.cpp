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

}  // namespace

double passive_stiffness(const CoupledAxis& axis) {
  return std::max(2 * (axis.damping - axis.coupling_damping) / axis.period, 0.0);
}

double two_port_margin(const CoupledAxis& axis) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kFrequencies; ++i) {
    // φ = ωT; at half the sampling rate the hold vanishes
    const double phi =
        std::numbers::pi * std::pow(kLowest, 1 - static_cast<double>(i + 1) / (kFrequencies + 1));
    const double hold = std::cos(0.5 * phi);
    const double device = axis.damping + axis.mass / axis.period * (1 - std::cos(phi));
    const double half = 0.5 * axis.stiffness * axis.period;
    const double real = axis.coupling_damping + half, imaginary = half / std::tan(0.5 * phi);
    const double size2 = real * real + imaginary * imaginary;
    const double compliance = size2 > 0 ? real / size2 : std::numeric_limits<double>::infinity();
    least = std::min(least, hold + 2 * device * compliance / hold - 1);
  }
  return least;
}

}  // namespace haptic

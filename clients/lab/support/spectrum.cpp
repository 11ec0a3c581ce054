// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/spectrum.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace haptic {

double rms_above(std::span<const Vec3> force, double rate, double cutoff) {
  const size_t size = force.size();
  if (size == 0) return 0;
  const auto n = static_cast<double>(size);
  const auto turns = [&](double of_n) { return 2 * std::numbers::pi * of_n / n; };
  std::vector<Vec3> windowed(size);
  double energy = 0;
  for (size_t i = 0; i < size; ++i) {
    // √(8/3): the window's own root mean square is √(3/8)
    const double hann = 0.5 - 0.5 * std::cos(turns(static_cast<double>(i) + 0.5));
    windowed[i] = std::sqrt(8.0 / 3) * hann * force[i];
    energy += norm_squared(windowed[i]) / n;
  }
  for (size_t k = 0; static_cast<double>(k) * rate / n <= cutoff && 2 * k <= size; ++k) {
    Vec3 re, im;
    for (size_t i = 0; i < size; ++i) {
      const double phase = turns(static_cast<double>(k * i % size));
      re += std::cos(phase) / n * windowed[i];
      im += std::sin(phase) / n * windowed[i];
    }
    energy -= (k == 0 || 2 * k == size ? 1 : 2) * (norm_squared(re) + norm_squared(im));
  }
  return std::sqrt(std::max(energy, 0.0));
}

}  // namespace haptic

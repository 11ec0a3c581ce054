// SPDX-License-Identifier: Apache-2.0
#include "proto/config/coupling_margin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "proto/config/devices.h"

namespace haptic {
namespace {

constexpr int kFrequencies = 4000;  // grid points, logarithmic up to half the sampling rate
constexpr double kLowest = 1e-6;    // lowest frequency, as a share of that

/// ω T of a grid point; at π, half the sampling rate, the hold vanishes.
double grid(int i) {
  return std::numbers::pi * std::pow(kLowest, 1 - static_cast<double>(i + 1) / (kFrequencies + 1));
}

}  // namespace

double passive_stiffness(const CoupledAxis& axis) {
  return std::max(2 * (axis.damping - axis.coupling_damping) / axis.period, 0.0);
}

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

CoupledAxis moving_axis(const SessionConfig& config) {
  const DeviceConfig& device = config.device;
  const bool is_simulated = device.kind == DeviceKind::kSimulatedHand;
  // the scene moves s times as far, and the device exerts φ times the force
  const double gain = config.map.motion_scale * config.map.force_scale;
  return {is_simulated ? device.hand.mass : device.mass,
          is_simulated ? device.hand.damping : device.damping,
          gain * config.coupling.translational_stiffness,
          gain * config.coupling.translational_damping, 1 / config.servo_rate};
}

CoupledAxis turning_axis(const SessionConfig& config) {
  const DeviceConfig& device = config.device;
  const bool is_simulated = device.kind == DeviceKind::kSimulatedHand;
  const double gain = config.map.force_scale;
  return {is_simulated ? device.hand.inertia : device.inertia,
          is_simulated ? device.hand.rotational_damping : device.rotational_damping,
          gain * config.coupling.rotational_stiffness, gain * config.coupling.rotational_damping,
          1 / config.servo_rate};
}

}  // namespace haptic

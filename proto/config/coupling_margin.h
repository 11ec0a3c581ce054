// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "proto/config/devices.h"
#include "proto/config/session_config.h"

namespace haptic {

/// One linear or angular axis of a device with its virtual coupling, in device units.
struct CoupledAxis {
  double mass = 0.1;            // m of the device [kg or kg·m²]
  double damping = 0;           // b of the device [N·s/m or N·m·s/rad]
  double stiffness = 0;         // k_c of the coupling [N/m or N·m/rad]
  double coupling_damping = 0;  // b_c [N·s/m or N·m·s/rad]
  double period = 1e-3;         // T of the servo [s]
};

/// The largest passive stiffness through a zero-order hold with the proxy fixed, k_c < 2 (b −
/// b_c)/T; 0 if b_c ≥ b (Colgate, Stanley, Brown 1995; Colgate & Schenkel 1997).
inline double passive_stiffness(const CoupledAxis& axis) {
  return std::max(2 * (axis.damping - axis.coupling_damping) / axis.period, 0.0);
}

/// Times the passive stiffness above which a stiffness is refused: the formula leaves out what a
/// hand damps, which is about as much as a device does (Adams & Hannaford 1999).
inline constexpr double kMostBeyond = 2;

/// True if a stiffness exceeds kMostBeyond times the passive one; false if the device's damping is
/// unknown (0).
inline bool is_far_beyond(const CoupledAxis& axis) {
  return axis.damping > 0 && axis.stiffness > kMostBeyond * passive_stiffness(axis);
}

/// Margin of unconditional stability of the two-port of device, hold and coupling, for any passive
/// hand and any passive virtual world (Llewellyn's criterion; Adams & Hannaford 1999): the minimum
/// over 0 < ω < π/T of
///   cos∠H + 2 Re Z_d Re(1/Z_c)/|H| − 1,  H = (1 + z⁻¹)/2, Z_d = b + m (1 − z⁻¹)/T,
///   Z_c = b_c + k_c T/(1 − z⁻¹),  z = exp(jωT).
/// ≥ 0: stable whatever is touched and however it is held, as far as Z_d models the device: the
/// backward difference gives it a damping m (1 − cos ωT)/T that real devices lack. So check
/// passive_stiffness as well.
double two_port_margin(const CoupledAxis& axis);
/// The expression whose minimum two_port_margin() is, at one frequency, ω T in (0, π).
double two_port_margin_at(const CoupledAxis& axis, double omega_t);
/// The lowest and the highest ω T that the minimum is taken over.
struct MarginBand {
  double lowest, highest;
};
MarginBand margin_band();

/// The axes of a session: the device of [device.hand] or the one that [device] describes, and the
/// coupling as it is felt at the handle, s·φ times that of the scene for moving, φ for turning.
inline CoupledAxis moving_axis(const SessionConfig& config) {
  const DeviceConfig& device = config.device;
  const bool is_simulated = device.kind == DeviceKind::kSimulatedHand;
  // the scene moves s times as far, and the device exerts φ times the force
  const double gain = config.map.motion_scale * config.map.force_scale;
  return {is_simulated ? device.hand.mass : device.mass,
          is_simulated ? device.hand.damping : device.damping,
          gain * config.coupling.translational_stiffness,
          gain * config.coupling.translational_damping, 1 / config.servo_rate};
}

/// True if the handle can turn; a simulated one without inertia cannot.
inline bool can_turn(const DeviceConfig& device) {
  return device.kind != DeviceKind::kSimulatedHand || device.hand.inertia > 0;
}

inline CoupledAxis turning_axis(const SessionConfig& config) {
  const DeviceConfig& device = config.device;
  const bool is_simulated = device.kind == DeviceKind::kSimulatedHand;
  const double gain = config.map.force_scale;
  return {is_simulated ? device.hand.inertia : device.inertia,
          is_simulated ? device.hand.rotational_damping : device.rotational_damping,
          gain * config.coupling.rotational_stiffness, gain * config.coupling.rotational_damping,
          1 / config.servo_rate};
}

}  // namespace haptic

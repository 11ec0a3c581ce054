// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptic {

/// One axis of a device, linear or angular, and the virtual coupling on it, in device units.
struct CoupledAxis {
  double mass = 0.1;            // m of the device there [kg or kg·m²]
  double damping = 0;           // b of the device [N·s/m or N·m·s/rad]
  double stiffness = 0;         // k_c of the coupling [N/m or N·m/rad]
  double coupling_damping = 0;  // b_c [N·s/m or N·m·s/rad]
  double period = 1e-3;         // T of the servo [s]
};

/// The largest stiffness that is passive through a zero-order hold with the proxy held fast,
/// k_c < 2 (b − b_c)/T, 0 where b_c ≥ b (Colgate, Stanley, Brown 1995; Colgate & Schenkel 1997).
double passive_stiffness(const CoupledAxis& axis);

/// Margin of unconditional stability of the two-port of device, hold and coupling, for any passive
/// hand and any passive virtual world (Llewellyn's criterion; Adams & Hannaford 1999): the least
/// over 0 < ω < π/T of
///   cos∠H + 2 Re Z_d Re(1/Z_c)/|H| − 1,  H = (1 + z⁻¹)/2, Z_d = b + m (1 − z⁻¹)/T,
///   Z_c = b_c + k_c T/(1 − z⁻¹),  z = exp(jωT).
/// ≥ 0: stable whatever is touched and however it is held, as far as the device is what Z_d says:
/// by the backward difference it has a damping m (1 − cos ωT)/T that real devices have not. Ask
/// passive_stiffness as well; with both there is no exception.
double two_port_margin(const CoupledAxis& axis);

}  // namespace haptic

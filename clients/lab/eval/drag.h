// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report/report.h"
#include "servo/solve/body/soft_proxy.h"

namespace haptic {

/// A hand that oscillates in free space: x = v/ω · sin ωt, with the rotation vector ω_T/ω · sin ωt
/// perpendicular to it.
struct FreeMotion {
  double speed = 2;      // v, peak [m/s]
  double turning = 10;   // ω_T, peak [rad/s]
  double frequency = 1;  // ω/2π [Hz]
  double dt = 1e-3;      // [s]
};

/// Largest force [N] or torque [N·m] that this hand feels after the transient, stepped through
/// solve_soft_proxy: the drag due to the mass and the coupling of the proxy. Zero for a proxy
/// without mass.
double free_space_drag(const SoftProxyModel& model, BodyTick tick, const FreeMotion& motion);

/// Closed form for a proxy with mass: m ω v |k_T + iωb_T| / |k_T − mω² + iωb_T|.
double drag_in_closed_form(const BodyTick& tick, const FreeMotion& motion);

/// Measures the drag in free space of proxies of 20 and 100 g on a coupling of 1000 N/m, for a hand
/// that oscillates at 1 Hz with up to 2 m/s. Goal: proxies without mass have exactly zero drag,
/// also while turning at 10 rad/s.
void eval_drag(const Rows& all);

}  // namespace haptic

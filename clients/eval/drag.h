// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "clients/report/report.h"
#include "servo/solve/body/soft_proxy.h"

namespace haptic {

/// A hand that moves to and fro where nothing is, and turns with it: x = v/ω · sin ωt, and a
/// rotation vector ω_T/ω · sin ωt across that.
struct FreeMotion {
  double speed = 2;      // v, the largest [m/s]
  double turning = 10;   // ω_T, the largest [rad/s]
  double frequency = 1;  // ω/2π [Hz]
  double dt = 1e-3;      // [s]
};

/// Largest force, or torque, that such a hand feels once the start is over, stepped through
/// solve_soft_proxy [N]: what a proxy's mass and the coupling take from free space. Zero where the
/// proxy has none.
double free_space_drag(const SoftProxyModel& model, const FreeMotion& motion);

/// The same in closed form for a proxy with mass: m ω v |k_T + iωb_T| / |k_T − mω² + iωb_T|.
double drag_in_closed_form(const SoftProxyModel& model, const FreeMotion& motion);

/// Measures the drag that a free hand feels from proxies of 20 and 100 g on a coupling of 1000 N/m,
/// while the hand moves to and fro at 1 Hz and up to 2 m/s. Those
/// without mass must feel exactly nothing, turned at 10 rad/s too.
std::vector<Row> eval_drag();

}  // namespace haptic

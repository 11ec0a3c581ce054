// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety.h"

#include <algorithm>

namespace haptic {
namespace {

/// Shortens a vector to the limit, direction kept. A limit of zero leaves nothing.
bool saturate(Vec3& a, double limit) {
  const double length = norm(a);
  if (length <= limit) return false;
  // scaled down first: a huge but finite vector has an infinite norm
  const double largest = std::max({std::fabs(a.x), std::fabs(a.y), std::fabs(a.z)});
  // a bit short of the limit, which rounding must not exceed
  a = limit * (1 - 0x1p-50) * normalized(a / largest);
  return true;
}

}  // namespace

SafetyOutput make_safe(const SafetyLimits& limits, SafetyState& state, const SafetyInput& input,
                       double dt) {
  if (input.fault_clears > state.fault_clears) {
    state.fault_clears = input.fault_clears;
    state.fault = false;
  }
  if (!input.input_finite || !is_finite(input.F_B)) state.fault = true;
  if (state.fault || input.force_closed) {
    state.gain = 0;
    return {{}, state.fault ? kServoFault : kServoSoftStart};
  }

  SafetyOutput out{input.F_B, 0};
  if (input.restart) state.gain = 0;
  if (limits.soft_start <= 0) state.gain = 1;
  if (state.gain < 1) {
    out.flags |= kServoSoftStart;
    out.F_B = state.gain * out.F_B;
    state.gain = std::min(1.0, state.gain + dt / limits.soft_start);
  }

  // a dropped torque is said once per tick it would have been felt
  if (limits.max_torque <= 0) {
    if (out.F_B.t != Vec3{}) out.flags |= kServoTorqueDropped;
    out.F_B.t = {};
  }
  const bool force_cut = saturate(out.F_B.f, limits.max_force);
  const bool torque_cut = saturate(out.F_B.t, limits.max_torque);
  if (force_cut || torque_cut) out.flags |= kServoSaturated;
  return out;
}

}  // namespace haptic

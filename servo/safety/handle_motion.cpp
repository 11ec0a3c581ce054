// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/handle_motion.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kJumpSpeed = 2;     // times the velocity limit
constexpr double kJumpWay = 2e-3;    // encoder steps and jitter of the time stamps [m]
constexpr double kJumpTurn = 20e-3;  // the same for turning: 2 mm at 100 mm [rad]
constexpr double kCalm = 0.1;        // slow enough to start again [m/s]
constexpr double kCalmTurning = 1;   // the same for turning: 0.1 m/s at 100 mm [rad/s]

bool is_turning_felt(const SafetyLimits& limits, const HandleStiffness& stiffness) {
  return limits.max_torque > 0 || stiffness.turning > 0;
}

}  // namespace

HandleSpeed speed_of(const SafetyLimits& limits, const HandleStiffness& stiffness,
                     const Twist& V_BH) {
  return {norm(V_BH.v), is_turning_felt(limits, stiffness) ? norm(V_BH.w) : 0};
}

bool is_too_fast(const SafetyLimits& limits, const HandleSpeed& speed) {
  return speed.moving > limits.velocity_limit || speed.turning > limits.angular_velocity_limit;
}

bool is_calm(const HandleSpeed& speed) {
  return speed.moving < kCalm && speed.turning < kCalmTurning;
}

HandleStep follow_handle(const SafetyLimits& limits, const HandleStiffness& stiffness,
                         LastSample& last, const DeviceState& device, int64_t now_ns) {
  const bool known = (device.flags & kDeviceHomed) != 0 && (device.flags & kDeviceLost) == 0;
  if (!known) last.known = false;
  if (!known || (device.flags & kDeviceFresh) == 0) return {};
  HandleStep step;
  if (last.known) {
    step.motion.way = norm(device.X_BH.p - last.X_BH.p);
    step.motion.turn = norm(to_rotation_vector(device.X_BH.q * conjugate(last.X_BH.q)));
    // up to now, since a late sample may be of any instant in between
    const double since = std::max(static_cast<double>(now_ns - last.measured_ns) * 1e-9, 0.0);
    const double farthest = kJumpWay + kJumpSpeed * limits.velocity_limit * since;
    const double widest = kJumpTurn + kJumpSpeed * limits.angular_velocity_limit * since;
    step.jumped = step.motion.way > farthest ||
                  (is_turning_felt(limits, stiffness) && step.motion.turn > widest);
  }
  last = {device.X_BH, device.t_ns, true};
  return step;
}

}  // namespace haptic

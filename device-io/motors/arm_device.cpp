// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/arm_device.h"

#include <algorithm>
#include <cmath>

#include "device-io/motors/holding.h"
#include "device-io/sensing/handle_velocity.h"
#include "device-io/sensing/saturate.h"
#include "proto/math/assert.h"

namespace haptic {
ArmDevice::ArmDevice(const Arm& arm, const DeviceConfig& config)
    : arm_(arm),
      max_force_(std::min(config.max_force, arm.max_force)),
      max_torque_(std::min(config.max_torque, arm.max_torque)),
      noise_(arm.most_accelerations()) {
  HAPTIC_ASSERT(arm_.find && arm_.jacobian);
  HAPTIC_ASSERT(arm_.most_effort > 0 && arm_.cutoff > 0 && arm_.max_force > 0);
  HAPTIC_ASSERT(arm_.motors > 0 && arm_.motors <= arm_.encoders && arm_.encoders <= kMostMotors);
}

DeviceCaps ArmDevice::caps() const {
  return {.max_force = max_force_, .max_torque = max_torque_, .is_planar = arm_.motors == 2};
}

Wrench ArmDevice::holding(const GravityConfig& gravity) const {
  return reachable_ ? holding_wrench(arm_, gravity, angles_, last_.X_BH) : Wrench{};
}

std::string ArmDevice::describe(bool is_homed, std::string_view not_homed) const {
  return arm_.name + (arm_.model > 0 ? " (model " + std::to_string(arm_.model) + ")" : "") + ", " +
         std::to_string(arm_.encoders) + " axes, " +
         (arm_.encoders > arm_.motors
              ? std::to_string(arm_.motors) + " of them driven (torque is dropped), "
              : "") +
         (is_homed ? "homed" : "NOT HOMED: " + std::string(not_homed));
}

void ArmDevice::take(const ArmSample& sample) {
  const Pose before_B = last_.X_BH;
  const double dt = 1e-9 * static_cast<double>(sample.asked_ns - last_.t_ns);
  const bool follows = sample.follows && reachable_ && dt > 0;
  last_.buttons = sample.buttons;
  last_.t_ns = sample.first_asked_ns;
  angles_ = arm_.angles(sample.counts);
  Pose X_BH = follows ? before_B : Pose{};
  reachable_ = arm_.find(angles_, X_BH);
  if (!reachable_) return;
  last_.X_BH = X_BH;
  if (follows) {
    low_pass_velocity(before_B, X_BH, dt, arm_.cutoff, last_.V_BH);
  } else {
    last_.V_BH = {};
    noise_.restart();
  }
  noise_.add(sample.counts, sample.first_asked_ns, sample.heard_ns);
}

MotorNumbers ArmDevice::numbers_for(Wrench F_B) {
  MotorNumbers numbers{};
  saturated_ = !is_finite(F_B);
  // what the device cannot exert is dropped, and none of it is missing
  if (arm_.max_torque == 0) F_B.t = {};
  if (arm_.motors == 2) F_B.f.z = 0;
  if (saturated_ || F_B == Wrench{}) return numbers;
  saturated_ |= saturate(F_B.f, max_force_);
  saturated_ |= saturate(F_B.t, max_torque_);
  MotorEfforts efforts;
  saturated_ |= !arm_.efforts(angles_, last_.X_BH, F_B, efforts);
  double largest = 0;
  for (const double effort : efforts) largest = std::max(largest, std::fabs(effort));
  saturated_ |= largest > arm_.most_effort;
  const double share = largest > arm_.most_effort ? arm_.most_effort / largest : 1;
  for (size_t i = 0; i < arm_.motors; ++i) {
    numbers[i] = static_cast<int32_t>(std::lround(arm_.numbers * (share * efforts[i])));
  }
  return numbers;
}

bool ArmDevice::give(bool is_fresh, uint32_t flags, DeviceState& state) {
  last_.flags = flags | (is_fresh ? kDeviceFresh : kDeviceHeld) |
                (saturated_ ? uint32_t{kDeviceSaturated} : 0) |
                (noise_.is_noisy() ? uint32_t{kDeviceNoisy} : 0);
  state = last_;
  return is_fresh;
}

}  // namespace haptic

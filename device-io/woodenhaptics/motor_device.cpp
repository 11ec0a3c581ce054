// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/motor_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "device-io/sensing/handle_velocity.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// Shortened to its limit, so it keeps its direction. True: it was changed.
bool saturate(Vec3& a, double limit) {
  const double size = norm(a);
  if (size <= limit) return false;
  a = limit / size * a;
  return true;
}

}  // namespace

MotorDevice::MotorDevice(const Arm& arm, const DeviceConfig& config, FileDescriptor node)
    : arm_(arm),
      max_force_(std::min(config.max_force, arm.max_force)),
      max_torque_(std::min(config.max_torque, arm.max_torque)),
      max_current_(config.serial.max_current),
      velocity_cutoff_(config.serial.velocity_cutoff),
      line_(arm, std::string(view(config.serial.path)), std::move(node)),
      noise_(arm.most_acceleration),
      angles_(arm.angles(line_.home())) {
  HAPTIC_ASSERT(max_current_ > 0 && velocity_cutoff_ > 0);
  last_.X_BH = arm_.pose(angles_);
  last_.flags = kDeviceHeld | line_.flags();
}

DeviceCaps MotorDevice::caps() const {
  return {
      .max_force = max_force_, .max_torque = max_torque_, .open_loop = false, .simulated = false};
}

std::string MotorDevice::description() const {
  return std::string(arm_.name) + " (model " + std::to_string(arm_.model) + "), " +
         std::to_string(arm_.encoders) + " axes, " +
         (arm_.encoders > arm_.motors
              ? std::to_string(arm_.motors) + " of them driven (torque is dropped), "
              : "") +
         (line_.is_homed() ? "homed" : "NOT HOMED: rest the arm at home, press its button");
}

void MotorDevice::move_to(const MotorLine::Sample& sample) {
  const Pose before_B = last_.X_BH;
  const double dt = 1e-9 * static_cast<double>(sample.asked_ns - last_.t_ns);
  angles_ = arm_.angles(sample.counts);
  last_.X_BH = arm_.pose(angles_);
  last_.buttons = sample.buttons;
  // the older instant: bounds the hand's motion over the longer time
  last_.t_ns = sample.first_asked_ns;
  if (!sample.follows || !(dt > 0)) {
    last_.V_BH = {};
    noise_.restart();
    return;
  }
  low_pass_velocity(before_B, last_.X_BH, dt, velocity_cutoff_, last_.V_BH);
}

bool MotorDevice::read(const TickTime& tick, DeviceState& state) {
  const auto sample = line_.hear(tick.now_ns);
  if (sample) {
    move_to(*sample);
    noise_.add(sample->counts, sample->first_asked_ns, tick.now_ns);
  }
  // nobody holds a button of a device that is gone
  if ((line_.flags() & kDeviceLost) != 0) last_.buttons = 0;
  last_.flags = (sample ? kDeviceFresh : kDeviceHeld) | line_.flags() |
                (saturated_ ? uint32_t{kDeviceSaturated} : 0) |
                (noise_.is_noisy() ? uint32_t{kDeviceNoisy} : 0);
  state = last_;
  return sample.has_value();
}

Milliamperes MotorDevice::currents_for(Wrench F_B) {
  saturated_ = !is_finite(F_B);
  if (saturated_) return {};
  // a device that does not turn takes no torque, which is then none that is missing
  if (arm_.max_torque == 0) F_B.t = {};
  saturated_ |= saturate(F_B.f, max_force_);
  saturated_ |= saturate(F_B.t, max_torque_);
  const MotorAmperes amperes = arm_.currents(angles_, F_B);
  double largest = 0;
  for (const double a : amperes) largest = std::max(largest, std::fabs(a));
  saturated_ |= largest > max_current_;
  const double share = largest > max_current_ ? max_current_ / largest : 1;
  Milliamperes whole;
  for (size_t i = 0; i < whole.size(); ++i) {
    whole[i] = static_cast<int32_t>(std::lround(1000 * (share * amperes[i])));
  }
  return whole;
}

void MotorDevice::write(const Wrench& F_B) {
  if (line_.may_say()) line_.say(currents_for(F_B));
}

}  // namespace haptic

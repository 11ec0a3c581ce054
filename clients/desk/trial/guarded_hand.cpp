// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/guarded_hand.h"

#include "servo/tick.h"

namespace haptic {
namespace {

constexpr double kMostSpeed = 0.3;        // of a held handle [m/s]; a reach has 1 m/s
constexpr double kMostTurning = 4;        // [rad/s]; the same at 75 mm from the wrist
constexpr double kGentleStart = 0.2;      // soft start [s]; the pushes have ramps of their own
constexpr double kNewtonsPerSecond = 50;  // slew [N/s]; 8 N in 160 ms, slower than a flinch

// a busy machine holds up a device for some ticks, without force; longer is the device's fault [s]
constexpr double kMostDoubt = 0.1;

bool is_trusted(const DeviceState& device) {
  constexpr uint32_t kBad = kDeviceLost | kDeviceStale | kDeviceNoisy;
  return (device.flags & kBad) == 0 && (device.flags & kDeviceHomed) != 0;
}

}  // namespace

GuardedHand::GuardedHand(const SafetyLimits& limits, double share, double most_way)
    : limits_(limits), pushes_(share > 0), most_way_(most_way) {
  limits_.max_force *= share;
  limits_.max_torque *= share;
  limits_.soft_start = kGentleStart;
  limits_.slew = kNewtonsPerSecond;
  limits_.torque_slew = 0;
  if (!pushes_) return;
  limits_.velocity_limit = kMostSpeed;
  limits_.angular_velocity_limit = kMostTurning;
}

TrialEnd GuardedHand::why_end(const DeviceState& device, uint32_t flags) const {
  // nothing is felt yet, so a device that has to wake up or be homed may do so
  if (!pushes_) return TrialEnd::kNone;
  if (untrusted_ > kMostDoubt) return TrialEnd::kLost;
  if ((flags & kServoFault) != 0) return TrialEnd::kFault;
  if ((flags & kServoTooFast) != 0) return TrialEnd::kTooFast;
  if (begun_ && norm(device.X_BH.p - begin_B_) > most_way_) return TrialEnd::kTooFar;
  return TrialEnd::kNone;
}

Wrench GuardedHand::tick(const DeviceState& device, int64_t now_ns, const Wrench& wanted_B,
                         double dt) {
  SafetyInput input{};
  input.F_B = wanted_B;
  input.device = device;
  input.now_ns = now_ns;
  input.device_finite = is_sound(device);
  input.armed = pushes_ && end_ == TrialEnd::kNone;
  input.force_closed = !is_trusted(device);
  const SafetyOutput safe = make_safe(limits_, state_, input, dt);
  if (!begun_ && is_trusted(device) && input.device_finite) {
    begin_B_ = device.X_BH.p;
    begun_ = true;
  }
  untrusted_ = is_trusted(device) ? 0 : untrusted_ + dt;
  if (end_ == TrialEnd::kNone) end_ = why_end(device, safe.flags);
  return end_ == TrialEnd::kNone ? safe.F_B : Wrench{};
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/three_motor_device.h"

#include <algorithm>
#include <utility>

#include "device-io/sensing/handle_velocity.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int64_t kSilenceNs = 20'000'000;  // without a sample the device is lost

}  // namespace

ThreeMotorDevice::ThreeMotorDevice(ThreeMotorArm arm, const DeviceConfig& config,
                                   std::shared_ptr<MotorMailbox> mailbox, MotorLink link)
    : arm_(std::move(arm)),
      max_force_(std::min(config.max_force, arm_.max_force)),
      mailbox_(std::move(mailbox)),
      link_(std::move(link)),
      noise_(arm_.most_acceleration) {
  HAPTIC_ASSERT(mailbox_ && arm_.velocity_cutoff > 0 && arm_.max_force > 0);
}

DeviceCaps ThreeMotorDevice::caps() const {
  return {.max_force = max_force_, .max_torque = 0, .open_loop = false, .simulated = false};
}

std::string ThreeMotorDevice::description() const {
  const std::optional<MotorSample> sample = mailbox_->newest();
  const bool homed = sample && arm_.is_homed(sample->flags);
  return arm_.name + ", " + std::to_string(arm_.axes) + " axes, " +
         (homed ? "homed" : "NOT HOMED: " + arm_.not_homed);
}

/// Unwraps the counts: the shorter way round, since no motor turns by half of the 16 bits in a
/// tick.
void ThreeMotorDevice::count(const MotorSample& sample) {
  for (size_t i = 0; i < sample.counts.size(); ++i) {
    const auto step = static_cast<int16_t>(sample.counts[i] - counts_[i]);
    counts_[i] = sampled_ && reachable_ ? counts_[i] + step : sample.counts[i];
  }
}

void ThreeMotorDevice::move_to(const MotorSample& sample) {
  const Pose before_B = last_.X_BH;
  const double dt = 1e-9 * static_cast<double>(sample.asked_ns - last_.t_ns);
  const bool follows = sampled_ && reachable_ && dt > 0;
  sampled_ = true;
  last_.t_ns = sample.asked_ns;
  reachable_ = arm_.place(counts_, follows, last_.X_BH.p);
  if (!reachable_) return;
  if (follows) {
    low_pass_velocity(before_B, last_.X_BH, dt, arm_.velocity_cutoff, last_.V_BH);
  } else {
    last_.V_BH = {};
    noise_.restart();
  }
  noise_.add(counts_, sample.asked_ns, sample.heard_ns);
}

uint32_t ThreeMotorDevice::flags(bool fresh, int64_t t_ns) const {
  uint32_t flags = fresh ? kDeviceFresh : kDeviceHeld;
  const bool silent = !sampled_ || t_ns - sample_.heard_ns > kSilenceNs;
  if (mailbox_->is_gone() || silent) flags |= kDeviceLost;
  // where no place of the handle fits the counts, they are not those of a homed device
  if (reachable_ && arm_.is_homed(sample_.flags)) flags |= kDeviceHomed;
  if (mailbox_->is_stale()) flags |= kDeviceStale;
  if (noise_.is_noisy()) flags |= kDeviceNoisy;
  if (saturated_) flags |= kDeviceSaturated;
  return flags;
}

bool ThreeMotorDevice::read(const TickTime& tick, DeviceState& state) {
  now_ns_ = tick.now_ns;
  const std::optional<MotorSample> newest = mailbox_->newest();
  const bool fresh = newest && (!sampled_ || newest->number != sample_.number);
  if (fresh) {
    count(*newest);
    move_to(*newest);
    sample_ = *newest;
  }
  last_.buttons = arm_.buttons(sample_.flags);
  last_.flags = flags(fresh, tick.now_ns);
  state = last_;
  return fresh;
}

void ThreeMotorDevice::write(const Wrench& F_B) {
  const bool ready = (last_.flags & (kDeviceLost | kDeviceHomed)) == kDeviceHomed;
  MotorCommand command;
  command.flags = arm_.command_flags(ready);
  saturated_ = !is_finite(F_B.f);
  Vec3 force_B = saturated_ || !ready ? Vec3{} : F_B.f;
  if (arm_.axes == 2) force_B.z = 0;
  const double size = norm(force_B);
  saturated_ |= size > max_force_;
  if (size > max_force_) force_B = max_force_ / size * force_B;
  bool clipped = false;
  if (size > 0) saturated_ |= !arm_.drive(force_B, command.motors, clipped);
  saturated_ |= clipped;
  mailbox_->post(command, now_ns_);
}

void ThreeMotorDevice::stop() {
  write({});
  if (link_.stop) link_.stop();
}

bool ThreeMotorDevice::tap(HearBytes hears) {
  if (link_.tap != nullptr) link_.tap->set(std::move(hears));
  return link_.tap != nullptr;
}

}  // namespace haptic

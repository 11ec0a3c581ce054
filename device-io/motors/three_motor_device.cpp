// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/three_motor_device.h"

#include <limits>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {

ThreeMotorDevice::ThreeMotorDevice(const Arm& arm, MotorFlags flags, const DeviceConfig& config,
                                   std::shared_ptr<MotorMailbox> mailbox,
                                   std::shared_ptr<TransferThread> thread)
    : ArmDevice(arm, config),
      flags_(std::move(flags)),
      mailbox_(std::move(mailbox)),
      thread_(std::move(thread)) {
  HAPTIC_ASSERT(mailbox_ && arm.encoders <= sample_.counts.size());
  // its mailbox holds numbers of 16 bits
  HAPTIC_ASSERT(arm.most_effort * arm.numbers <= std::numeric_limits<int16_t>::max());
}

std::string ThreeMotorDevice::description() const {
  const std::optional<MotorSample> sample = mailbox_->newest();
  return describe(sample && is_homed(*sample), flags_.not_homed);
}

/// Unwraps the counts: the shorter way round, since no motor turns by half of the 16 bits in a
/// tick.
void ThreeMotorDevice::count(const MotorSample& sample) {
  for (size_t i = 0; i < sample.counts.size(); ++i) {
    const auto step = static_cast<int16_t>(sample.counts[i] - counts_[i]);
    counts_[i] = sampled_ && reachable_ ? counts_[i] + step : sample.counts[i];
  }
}

uint32_t ThreeMotorDevice::flags(int64_t t_ns) const {
  uint32_t flags = 0;
  const bool silent = !sampled_ || t_ns - sample_.heard_ns > kDeviceSilenceNs;
  if (mailbox_->is_gone() || silent) flags |= kDeviceLost;
  // where no place of the handle fits the counts, they are not those of a homed device
  if (sampled_ && reachable_ && is_homed(sample_)) flags |= kDeviceHomed;
  if (mailbox_->is_stale()) flags |= kDeviceStale;
  return flags;
}

bool ThreeMotorDevice::read(const TickTime& tick, DeviceState& state) {
  now_ns_ = tick.now_ns;
  const std::optional<MotorSample> newest = mailbox_->newest();
  const bool fresh = newest && (!sampled_ || newest->number != sample_.number);
  if (fresh) {
    count(*newest);
    sample_ = *newest;
    take({counts_, uint32_t{sample_.flags} & flags_.buttons, sample_.asked_ns, sample_.asked_ns,
          sample_.heard_ns, sampled_});
    sampled_ = true;
  }
  return give(fresh, flags(tick.now_ns), state);
}

void ThreeMotorDevice::write(const Wrench& F_B) {
  const bool ready = (last_.flags & (kDeviceLost | kDeviceHomed)) == kDeviceHomed;
  // a force that is not finite is said even where there is none
  const bool is_told = ready || !is_finite(F_B.f);
  const MotorNumbers numbers = numbers_for({is_told ? F_B.f : Vec3{}, {}});
  MotorCommand command{{}, ready ? flags_.ready : flags_.idle};
  for (size_t i = 0; i < command.motors.size(); ++i) {
    command.motors[i] = static_cast<int16_t>(numbers[i]);
  }
  mailbox_->post(command, now_ns_);
}

void ThreeMotorDevice::stop() {
  write({});
  if (thread_) thread_->stop();
}

bool ThreeMotorDevice::tap(HearBytes hears) {
  if (thread_) thread_->tap(std::move(hears));
  return thread_ != nullptr;
}

}  // namespace haptic

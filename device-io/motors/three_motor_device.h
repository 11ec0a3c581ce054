// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "device-io/motors/arm_device.h"
#include "device-io/motors/motor_mailbox.h"
#include "device-io/motors/transfer_thread.h"

namespace haptic {

/// The meaning of the flags of a device's samples and commands, and its zero force.
struct MotorFlags {
  uint8_t homed = 0;            // it is homed where all of them are set: always, without any
  uint8_t buttons = 0;          // one a button
  uint8_t ready = 0, idle = 0;  // of a command to a device that is ready, or is not
  std::string not_homed{};      // what a person is to do
  DeviceRelease release{};
};

/// A device of at most three motors with encoders of 16 bits, whose transfers run in a thread of
/// their own: read() and write() exchange with it by a MotorMailbox, and never wait.
///
/// Lost: no sample for kDeviceSilenceNs, or unplugged. Stale: the mailbox says so. Not homed: by
/// the sample's flags, or no place has its counts.
class ThreeMotorDevice : public ArmDevice {
 public:
  /// `thread` serves the mailbox and ends with its last owner; none: somebody else does.
  ThreeMotorDevice(const Arm& arm, MotorFlags flags, const DeviceConfig& config,
                   std::shared_ptr<MotorMailbox> mailbox,
                   std::shared_ptr<TransferThread> thread = {});

  std::string description() const override;
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  void stop() override;
  bool tap(HearBytes hears) override;
  DeviceRelease release() const override { return flags_.release; }

 protected:
  /// The instant of the last read().
  int64_t now_ns() const { return now_ns_; }

 private:
  void count(const MotorSample& sample);
  uint32_t flags(int64_t t_ns) const;
  bool is_homed(const MotorSample& sample) const {
    return (sample.flags & flags_.homed) == flags_.homed;
  }

  MotorFlags flags_;
  std::shared_ptr<MotorMailbox> mailbox_;
  std::shared_ptr<TransferThread> thread_;  // after the mailbox, which it uses
  MotorCounts counts_{};
  MotorSample sample_{};  // the newest
  int64_t now_ns_ = 0;
  bool sampled_ = false;
};

}  // namespace haptic

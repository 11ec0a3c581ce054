// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "device-io/motors/arm_device.h"
#include "device-io/motors/byte_tap.h"
#include "device-io/motors/motor_mailbox.h"

namespace haptic {

/// What the flags of a device's samples and commands mean, and its zero force.
struct MotorFlags {
  uint8_t homed = 0;            // it is homed where all of them are set: always, without any
  uint8_t buttons = 0;          // one a button
  uint8_t ready = 0, idle = 0;  // of a command to a device that is ready, or is not
  std::string not_homed{};      // what a person is to do
  DeviceRelease release{};
};

/// The thread of transfers behind a mailbox; empty: somebody else serves it (tests in virtual
/// time).
struct MotorLink {
  std::shared_ptr<void> thread{};  // ends with its last owner
  std::function<void()> stop{};    // waits until the last command has been sent
  ByteTap* tap = nullptr;          // of the thread; null: it tells nobody
};

/// A device of at most three motors with encoders of 16 bits, whose transfers run in a thread of
/// their own: read() and write() exchange with it by a MotorMailbox, and never wait.
///
/// Lost: no sample for kDeviceSilenceNs, or unplugged. Stale: the mailbox says so. Not homed: by
/// the sample's flags, or no place has its counts.
class ThreeMotorDevice final : public ArmDevice {
 public:
  ThreeMotorDevice(const Arm& arm, MotorFlags flags, const DeviceConfig& config,
                   std::shared_ptr<MotorMailbox> mailbox, MotorLink link = {});

  std::string description() const override;
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  void stop() override;
  bool tap(HearBytes hears) override;
  DeviceRelease release() const override { return flags_.release; }

 private:
  void count(const MotorSample& sample);
  uint32_t flags(int64_t t_ns) const;
  bool is_homed(const MotorSample& sample) const {
    return (sample.flags & flags_.homed) == flags_.homed;
  }

  MotorFlags flags_;
  std::shared_ptr<MotorMailbox> mailbox_;
  MotorLink link_;  // after the mailbox, which it uses
  MotorCounts counts_{};
  MotorSample sample_{};  // the newest
  int64_t now_ns_ = 0;
  bool sampled_ = false;
};

}  // namespace haptic

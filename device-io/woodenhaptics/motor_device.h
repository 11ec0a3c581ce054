// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "device-io/motors/arm_device.h"
#include "device-io/woodenhaptics/motor_line.h"

namespace haptic {

/// An arm on a serial node. A sample is one tick old: t_ns is the instant of the write that asked
/// for it. The loop thus has one tick of delay in addition to the hold: a wall is stable for
/// K < (b + B)/(3T/2). Lost, stale and homed as MotorLine says.
class MotorDevice final : public ArmDevice {
 public:
  /// Takes the open node and waits until the device answers. Throws DeviceError if it does not
  /// within two seconds, std::runtime_error if it is another model.
  MotorDevice(const Arm& arm, const DeviceConfig& config, FileDescriptor node);

  std::string description() const override;
  /// Reads at most 1 KiB; the newest answer counts.
  bool read(const TickTime& tick, DeviceState& state) override;
  /// Sends nothing while the last line is unanswered (MotorLine::may_say).
  void write(const Wrench& F_B) override;
  void stop() override { line_.stop(); }
  DeviceRelease release() const override { return line_.release(); }

  /// Invalid answers and answers with an error.
  uint64_t rejected() const { return line_.rejected(); }
  /// Currents of the last line sent [mA].
  const Milliamperes& currents() const { return line_.currents(); }

 private:
  MotorLine line_;
};

/// Opens an arm on its node, at [device.serial] where that is not open yet. Throws as MotorDevice
/// and open_node() do.
std::unique_ptr<Device> open_motor_device(const Arm& arm, const DeviceConfig& config,
                                          FileDescriptor node);

}  // namespace haptic

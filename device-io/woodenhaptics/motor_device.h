// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "device-io/device.h"
#include "device-io/motors/arm.h"
#include "device-io/sensing/encoder_noise.h"
#include "device-io/woodenhaptics/motor_line.h"

namespace haptic {

/// A device of motors with encoders on a serial node. A sample is one tick old:
/// t_ns is the instant of the write that asked for it. The loop thus has one tick of delay in
/// addition to the hold: a wall is stable for K < (b + B)/(3T/2).
///
/// Pose: that of the arm's joint angles; velocity: backward difference over the time between
/// samples through one pole, of the orientation that of its rotation vector. Wrench: the arm's
/// currents at the pose of the last sample. Force and torque are each scaled down if they exceed
/// max_force and max_torque (of the config or of the arm), then all of it if a motor exceeds
/// max_current; one that is not finite is sent as zero; all set kDeviceSaturated in the next state.
///
/// Lost, stale and homed as MotorLine says; kDeviceNoisy by EncoderNoise, until the device has
/// recovered.
class MotorDevice : public Device {
 public:
  /// Takes the open node and waits until the device answers. Throws DeviceError if it does not
  /// within two seconds, std::runtime_error if it is another model.
  MotorDevice(const Arm& arm, const DeviceConfig& config, FileDescriptor node);

  DeviceCaps caps() const override;
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
  void move_to(const MotorLine::Sample& sample);
  Milliamperes currents_for(Wrench F_B);

  const Arm& arm_;
  double max_force_, max_torque_, max_current_, velocity_cutoff_;
  MotorLine line_;
  EncoderNoise noise_;
  JointAngles angles_;
  DeviceState last_{};
  bool saturated_ = false;
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "device-io/device.h"
#include "device-io/motors/arm.h"
#include "device-io/sensing/encoder_noise.h"

namespace haptic {

/// The counts that an answer of an arm gave.
struct ArmSample {
  MotorCounts counts{};
  uint32_t buttons = 0;        // one bit a button
  int64_t first_asked_ns = 0;  // of the first question that the answer may be to
  int64_t asked_ns = 0;        // of the last
  int64_t heard_ns = 0;
  bool follows = false;  // another sample, without a loss in between
};

/// The common part of all drivers of arms: the handle's state by the counts of its encoders, and
/// the motors' numbers by the wrench on the hand.
///
/// Pose: that of the arm's joint angles, at the older instant of the question, which bounds the
/// hand's motion over the longer time; velocity: backward difference over the time between samples
/// through one pole, of the orientation that of its rotation vector. Wrench: the motors' at the
/// pose of the last sample. Force and torque are each scaled down if they exceed max_force and
/// max_torque (of the config or of the arm), then all of it if a motor exceeds its limit; one that
/// is not finite is zero; all set kDeviceSaturated in the next state. kDeviceNoisy by EncoderNoise.
class ArmDevice : public Device {
 public:
  DeviceCaps caps() const override;
  Wrench holding(const GravityConfig& gravity) const override;

 protected:
  ArmDevice(const Arm& arm, const DeviceConfig& config);

  /// `not_homed`: what a person is to do then.
  std::string describe(bool is_homed, std::string_view not_homed) const;
  void take(const ArmSample& sample);
  MotorNumbers numbers_for(Wrench F_B);
  /// Ends a read: `flags` are those of the line.
  bool give(bool is_fresh, uint32_t flags, DeviceState& state);

  Arm arm_;
  DeviceState last_{};
  bool reachable_ = true;  // a pose has the counts of the last sample

 private:
  double max_force_, max_torque_;
  EncoderNoise noise_;
  JointAngles angles_{};
  bool saturated_ = false;
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "device-io/device.h"
#include "device-io/motors/byte_tap.h"
#include "device-io/motors/motor_mailbox.h"
#include "device-io/sensing/encoder_noise.h"

namespace haptic {

/// An arm of three motors with encoders of 16 bits: its name, and its kinematics as functions
/// without state that neither allocate nor throw. Places are those of the handle in B.
struct ThreeMotorArm {
  std::string name;
  int axes = 3;  // 2: it moves in the plane z = 0 of B; force along z is dropped, and none missing
  double max_force = 0;                                 // [N]
  double velocity_cutoff = 0;                           // [Hz]
  std::array<double, kMostMotors> most_acceleration{};  // of the encoders (EncoderNoise)

  /// Moves p_B to where these counts are; `follows`: p_B is the place of the sample before. False,
  /// and p_B stays: no place has these counts.
  std::function<bool(const MotorCounts& counts, bool follows, Vec3& p_B)> place;
  /// Motors that push the hand with F_B at the sample's place, clipped by one factor. False, and
  /// `motors` is zero: the pose is singular.
  std::function<bool(const Vec3& F_B, std::array<int16_t, 3>& motors, bool& clipped)> drive;

  /// By the flags of a sample.
  std::function<bool(uint8_t flags)> is_homed;
  std::function<uint32_t(uint8_t flags)> buttons;
  /// Flags of a command to a device that is ready, or is not.
  std::function<uint8_t(bool ready)> command_flags;
  std::string not_homed;  // what a person is to do
  DeviceRelease release{};
};

/// The thread of transfers behind a mailbox; empty: somebody else serves it (tests in virtual
/// time).
struct MotorLink {
  std::shared_ptr<void> thread{};  // ends with its last owner
  std::function<void()> stop{};    // waits until the last command has been sent
  ByteTap* tap = nullptr;          // of the thread; null: it tells nobody
};

/// A device of three motors whose transfers run in a thread of their own: read() and write()
/// exchange with it by a MotorMailbox, and never wait.
///
/// Velocity: backward difference through one pole. Lost: no sample for 20 ms, or unplugged. Stale:
/// the mailbox says so. Noisy: by EncoderNoise. Not homed: by the sample's flags, or no place has
/// its counts. Force is clipped to max_force and to the motors; one that is not finite is zero.
class ThreeMotorDevice final : public Device {
 public:
  ThreeMotorDevice(ThreeMotorArm arm, const DeviceConfig& config,
                   std::shared_ptr<MotorMailbox> mailbox, MotorLink link = {});

  DeviceCaps caps() const override;
  std::string description() const override;
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  void stop() override;
  bool tap(HearBytes hears) override;
  DeviceRelease release() const override { return arm_.release; }

 private:
  void count(const MotorSample& sample);
  void move_to(const MotorSample& sample);
  uint32_t flags(bool fresh, int64_t t_ns) const;

  ThreeMotorArm arm_;
  double max_force_;
  std::shared_ptr<MotorMailbox> mailbox_;
  MotorLink link_;  // after the mailbox, which it uses
  EncoderNoise noise_;
  MotorCounts counts_{};
  DeviceState last_{};
  MotorSample sample_{};  // the newest
  int64_t now_ns_ = 0;
  bool sampled_ = false, reachable_ = false, saturated_ = false;
};

}  // namespace haptic

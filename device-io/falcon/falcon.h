// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "device-io/device.h"
#include "device-io/falcon/kinematics.h"
#include "device-io/sensing/encoder_noise.h"
#include "device-io/sensing/motor_mailbox.h"

namespace haptic {

class FalconLink;

/// A Novint Falcon: three sensed and three driven axes. Frame B as in kinematics.h. The transfers
/// run in a thread of their own (FalconLink); read() and write() exchange with it by atomics.
///
/// A sample is one to two ticks old, since the chip holds short answers back for 1 ms: a wall is
/// stable for K < (b + B)/(T/2 + t_d), some 500 N/m. Velocity: backward difference through one
/// pole.
///
/// Lost: no answer for 20 ms, or unplugged. Homed: pulled fully out and pushed fully in since it
/// was switched on, by its own bits. Stale: answers do not match the questions, or no encoder has
/// moved for kStillNs although force was commanded, which no hand can do. Noisy: by EncoderNoise.
class Falcon final : public Device {
 public:
  /// `link` serves the mailbox; none: somebody else does (tests in virtual time).
  Falcon(const DeviceConfig& config, std::unique_ptr<MotorMailbox> mailbox,
         std::unique_ptr<FalconLink> link);
  ~Falcon() override;

  DeviceCaps caps() const override;
  std::string description() const override;
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  void stop() override;
  DeviceRelease release() const override;

  /// The limit of the design [N]; CHAI3D has the same.
  static constexpr double kMaxForce = 8;

 private:
  bool take(const MotorSample& sample);
  void move_to(const MotorSample& sample);
  uint32_t flags(bool fresh, int64_t t_ns) const;

  double max_force_, velocity_cutoff_;
  std::unique_ptr<MotorMailbox> mailbox_;
  std::unique_ptr<FalconLink> link_;
  FalconGeometry geometry_;
  FalconPose pose_;
  EncoderNoise noise_;
  MotorCounts counts_{};
  DeviceState last_{};
  uint8_t flags_ = 0;  // of the newest sample
  uint8_t number_ = 0;
  int64_t heard_ns_ = 0;  // the newest sample
  int64_t now_ns_ = 0;
  bool sampled_ = false, reachable_ = false, saturated_ = false;
};

}  // namespace haptic

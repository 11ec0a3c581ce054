// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/device.h"
#include "device-io/hand/plant.h"

namespace haptic {

/// How much simulated time one read may catch up with: 2500 steps, about half a millisecond. What a
/// read is later than that, the hand and its intention do not live through: kDeviceLostTime.
inline constexpr int64_t kMaxCatchUpNs = 50'000'000;

/// A 3-DoF device in a simulated hand, closed loop: the force held between two writes moves it for
/// as long as really passed between the reads. Its orientation is the identity and torque has no
/// effect. The position is floor(x/Δ)·Δ per axis; the velocity is its backward difference through a
/// one-pole low-pass. A force above the actuators' limit is shortened, its direction kept; one that
/// is not finite is held as zero; both are flagged kDeviceSaturated in the next state. One seed,
/// one sequence of read times and forces: the same states bit for bit.
class SimulatedHand final : public Device {
 public:
  explicit SimulatedHand(const DeviceConfig& config);

  DeviceCaps caps() const override;
  std::string description() const override;
  /// The plant starts at the first read. False where time has not advanced.
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  void stop() override;

  /// The truth behind the encoder, and its energy.
  const HandPlant& plant() const { return plant_; }
  /// Force on the handle now [N].
  const Vec3& held_force() const { return held_force_B_; }

 private:
  void move_on(int64_t elapsed_ns);
  Vec3 encoder_position() const;

  SimulatedHandConfig config_;
  double max_force_;
  HandPlant plant_;
  Vec3 held_force_B_;
  DeviceState last_{};
  bool lost_time_ = false;
  bool started_ = false;
  bool saturated_ = false;
};

}  // namespace haptic

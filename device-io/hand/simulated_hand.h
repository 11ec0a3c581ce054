// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/device.h"
#include "device-io/hand/plant.h"

namespace haptic {

/// Longest simulated time one read catches up with [ns]: 2500 steps, about half a millisecond of
/// computing. Time beyond that is skipped and flagged kDeviceLostTime.
inline constexpr int64_t kMaxCatchUpNs = 50'000'000;

/// A 3-DoF device in a simulated hand, closed loop: the force held between two writes moves it for
/// the time that passed between the reads. The orientation is the identity, torque has no effect.
/// Position: floor(x/Δ)·Δ per axis; velocity: its backward difference through a one-pole low-pass.
/// Forces above the actuators' limit are scaled down, forces that are not finite replaced by zero;
/// both set kDeviceSaturated in the next state. The same seed, read times and forces give the same
/// states bit for bit.
class SimulatedHand final : public Device {
 public:
  explicit SimulatedHand(const DeviceConfig& config);
  /// With another intention than that of config.hand.
  SimulatedHand(const DeviceConfig& config, Intention intention);

  DeviceCaps caps() const override;
  std::string description() const override;
  /// The plant starts at the first read. False if time has not advanced.
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override;
  /// Leads the intent, within the workspace (led_intent.h): the plant is still pushed back by the
  /// force and falls behind. Nobody is led where no hand's spring holds the device.
  void lead(const std::optional<Vec3>& p_BH) override;
  void stop() override;

  /// The true state behind the encoder, with its energies.
  const HandPlant& plant() const { return plant_; }
  /// Force on the handle now [N].
  const Vec3& held_force() const { return held_force_B_; }

 private:
  void move_on(int64_t elapsed_ns);
  Vec3 encoder_position() const;

  SimulatedHandConfig config_;
  Intention intention_;
  double max_force_;
  Ball reach_;
  HandPlant plant_;
  Vec3 held_force_B_;
  DeviceState last_{};
  bool lost_time_ = false;
  bool started_ = false;
  bool saturated_ = false;
};

}  // namespace haptic

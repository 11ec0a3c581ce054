// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "device-io/device.h"
#include "device-io/hand/plant.h"

namespace haptic {

/// Longest simulated time one read catches up with [ns]: 2500 steps, about half a millisecond of
/// computing. Time beyond that is skipped and flagged kDeviceLostTime.
inline constexpr int64_t kMaxCatchUpNs = 50'000'000;

/// The places that the intent can be led to: the device's workspace, or as far as an arm reaches.
Ball reach_of(const DeviceConfig& config);

/// A device in a simulated hand, closed loop: the wrench held between two writes moves it for the
/// time that passed between the reads. Without an inertia in the config the handle cannot turn: the
/// orientation is the identity, torque has no effect.
/// Position: floor(x/Δ)·Δ per axis; orientation: the same of its rotation vector from the identity;
/// velocities: their backward differences through a one-pole low-pass. Forces and torques above the
/// actuators' limit are scaled down, each for itself, a wrench that is not finite is replaced by
/// zero; all set kDeviceSaturated in the next state. The same seed, read times and forces give the
/// same states bit for bit.
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
  /// wrench and falls behind. Nobody is led where no hand's spring holds the device.
  void lead(const std::optional<Pose>& X_BH) override;
  void stop() override;

  /// The true state behind the encoder, with its energies.
  const HandPlant& plant() const { return plant_; }
  /// Wrench on the handle now.
  const Wrench& held() const { return held_B_; }

 private:
  void move_on(int64_t elapsed_ns);
  Pose encoder_pose() const;

  SimulatedHandConfig config_;
  Intention intention_;
  double max_force_, max_torque_;
  Ball reach_;
  HandPlant plant_;
  Wrench held_B_;
  DeviceState last_{};
  bool lost_time_ = false;
  bool started_ = false;
  bool saturated_ = false;
};

}  // namespace haptic

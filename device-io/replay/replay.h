// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "device-io/device.h"
#include "device-io/hand/simulated_hand.h"
#include "device-io/replay/recorded_motion.h"

namespace haptic {

/// A recording played back: open loop, the force has no effect. The first tick shows the first
/// sample; later ones follow the deadlines, so a late tick does not distort the motion.
class Replay final : public Device {
 public:
  /// Loads config.replay. Throws what load_hand_trace throws, and std::runtime_error if from and to
  /// leave nothing of the recording.
  explicit Replay(const DeviceConfig& config);
  Replay(HandCurve curve, double max_force, const ReplayConfig& config = {});

  DeviceCaps caps() const override;
  std::string description() const override { return motion_.curve().description(); }
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench&) override {}
  void stop() override {}

 private:
  RecordedMotion motion_;
  double max_force_;
  int64_t first_deadline_ns_ = 0;
  bool started_ = false;
};

/// A recorded motion as the intention of a simulated hand: the hand of [device.hand] holds the
/// device and is drawn towards the recorded pose by its springs and dampers, and forces and torques
/// push it back. Where the handle has no inertia its orientation is the recorded one: torque has no
/// effect.
class ClosedLoopReplay final : public Device {
 public:
  /// Begins as Replay does; the hand needs a stiffness.
  explicit ClosedLoopReplay(const DeviceConfig& config);
  ClosedLoopReplay(const ClosedLoopReplay&) = delete;  // the hand refers to the motion

  DeviceCaps caps() const override { return hand_.caps(); }
  std::string description() const override;
  bool read(const TickTime& tick, DeviceState& state) override;
  void write(const Wrench& F_B) override { hand_.write(F_B); }
  void stop() override { hand_.stop(); }

  const SimulatedHand& hand() const { return hand_; }

 private:
  RecordedMotion motion_;
  SimulatedHand hand_;
  bool turns_;
};

}  // namespace haptic

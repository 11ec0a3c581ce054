// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/replay/replay.h"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

namespace haptic {
namespace {

HandCurve load_curve(const ReplayConfig& config) {
  return {load_hand_trace(config).samples, config.resampling, config.max_gap};
}

}  // namespace

Replay::Replay(const DeviceConfig& config)
    : Replay(load_curve(config.replay), config.max_force, config.replay) {}

Replay::Replay(HandCurve curve, double max_force, const ReplayConfig& config)
    : motion_(std::move(curve), config), max_force_(max_force) {}

DeviceCaps Replay::caps() const {
  return {.max_force = max_force_, .max_torque = 0, .open_loop = true, .simulated = false};
}

bool Replay::read(const TickTime& tick, DeviceState& state) {
  if (!started_) first_deadline_ns_ = tick.deadline_ns;
  started_ = true;
  state = motion_.at(tick.deadline_ns - first_deadline_ns_);
  state.t_ns += first_deadline_ns_;
  return (state.flags & kDeviceFresh) != 0;
}

ClosedLoopReplay::ClosedLoopReplay(const DeviceConfig& config)
    : motion_(load_curve(config.replay), config.replay),
      hand_(config,
            [this](double t) {
              const DeviceState intended = motion_.at(std::llround(t * 1e9));
              return Intent{intended.X_BH.p, intended.V_BH.v, intended.X_BH.q, intended.V_BH.w};
            }),
      turns_(can_turn(config.hand)) {
  if (!(config.hand.hand_stiffness > 0)) {
    throw std::runtime_error(
        "[device.replay] closed_loop needs a hand that holds the device: hand_stiffness in "
        "[device.hand] is 0");
  }
}

std::string ClosedLoopReplay::description() const {
  return "SIMULATED hand with a recorded intention, closed loop; " + motion_.curve().description();
}

bool ClosedLoopReplay::read(const TickTime& tick, DeviceState& state) {
  const bool is_new = hand_.read(tick, state);
  // what is felt begins and ends with the recording; where the hand is, the plant says
  const DeviceState intended = motion_.at(hand_.plant().t_ns);
  if (!turns_) {
    state.X_BH.q = intended.X_BH.q;
    state.V_BH.w = intended.V_BH.w;
  }
  state.grip = intended.grip;
  state.buttons = intended.buttons;
  if ((intended.flags & kDeviceHomed) == 0) state.flags &= ~uint32_t{kDeviceHomed};
  state.flags |= intended.flags & kDeviceEnded;
  return is_new;
}

std::unique_ptr<Device> open_replay(const DeviceConfig& config, FileDescriptor) {
  if (config.replay.closed_loop != 0) return std::make_unique<ClosedLoopReplay>(config);
  return std::make_unique<Replay>(config);
}

}  // namespace haptic

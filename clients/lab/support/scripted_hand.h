// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <utility>

#include "device-io/device.h"
#include "proto/config/config.h"

namespace haptic {

/// A hand that follows a given function regardless of force: position or pose of the tool at time
/// t [s] after its first tick. Motors of `max_torque` [N·m] hold the torque that it is told.
class ScriptedHand : public Device {
 public:
  explicit ScriptedHand(std::function<Vec3(double)> path)
      : path_([path = std::move(path)](double t) {
          return Pose{path(t), {}};
        }) {}
  explicit ScriptedHand(std::function<Pose(double)> path, double max_torque = 0)
      : path_(std::move(path)), max_torque_(max_torque) {}

  DeviceCaps caps() const override { return {1e3, max_torque_, true, true}; }
  std::string description() const override { return "scripted"; }
  bool read(const TickTime& tick, DeviceState& state) override {
    if (first_ns_ < 0) first_ns_ = tick.deadline_ns;
    const double t = static_cast<double>(tick.deadline_ns - first_ns_) * 1e-9;
    state = {};
    state.t_ns = tick.deadline_ns;
    state.X_BH = path_(t);
    const Pose after = path_(t + 1e-6), before = path_(t - 1e-6);
    state.V_BH.v = (after.p - before.p) / 2e-6;
    state.V_BH.w = to_rotation_vector(after.q * conjugate(before.q)) / 2e-6;
    state.flags = kDeviceFresh | kDeviceHomed | kDeviceOpenLoop | kDeviceSimulated;
    return true;
  }
  void write(const Wrench& F_B) override { held = F_B; }
  void stop() override { held = {}; }

  Wrench held;

 private:
  std::function<Pose(double)> path_;
  double max_torque_ = 0;
  int64_t first_ns_ = -1;
};

/// A session of one object at full force from the start: no soft start, no damping, high limit.
inline SessionConfig plain_session(double stiffness) {
  SessionConfig config;
  config.coupling.translational_stiffness = stiffness;
  config.safety.soft_start = 0;
  config.safety.max_force = 1e3;
  config.n_objects = 1;
  return config;
}

}  // namespace haptic

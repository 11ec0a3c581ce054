// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <functional>

#include "device-io/device.h"

namespace haptic::test {

inline constexpr double kPi = 3.14159265358979323846;

/// A hand that follows a formula whatever the force: position of the tool at time t [s].
class ScriptedHand : public Device {
 public:
  explicit ScriptedHand(std::function<Vec3(double)> path) : path_(std::move(path)) {}

  DeviceCaps caps() const override { return {1e3, 0, true, true}; }
  std::string description() const override { return "scripted"; }
  bool read(const TickTime& tick, DeviceState& state) override {
    if (first_ns_ < 0) first_ns_ = tick.deadline_ns;
    const double t = static_cast<double>(tick.deadline_ns - first_ns_) * 1e-9;
    state = {};
    state.t_ns = tick.deadline_ns;
    state.X_BH.p = path_(t);
    state.V_BH.v = (path_(t + 1e-6) - path_(t - 1e-6)) / 2e-6;
    state.flags = kDeviceFresh | kDeviceHomed | kDeviceOpenLoop | kDeviceSimulated;
    return true;
  }
  void write(const Wrench& F_B) override { held = F_B; }
  void stop() override { held = {}; }

  Wrench held;

 private:
  std::function<Vec3(double)> path_;
  int64_t first_ns_ = -1;
};

/// Depth of the published tool path: 5 mm above, down over half a second, then 1 mm ± 0.4 mm.
inline double workload_depth(double t) {
  const double depth = 1e-3 + 0.4e-3 * std::sin(2 * kPi * 1.7 * t);
  if (t >= 0.5) return depth;
  double s = t < 0 ? 0 : t / 0.5;
  s = s * s * (3 - 2 * s);
  return -5e-3 * (1 - s) + depth * s;
}

/// The tool over the flat field z = 0, at workload_depth below it.
inline Vec3 flat_slide(double t) {
  return {0.075 * std::sin(2 * kPi * 0.23 * t), 0.075 * std::sin(2 * kPi * 0.17 * t + 0.9),
          -workload_depth(t)};
}

/// A session that starts at full force: no soft start, no damping, generous limit.
inline SessionConfig plain_session(double stiffness) {
  SessionConfig config;
  config.coupling.translational_stiffness = stiffness;
  config.safety.soft_start = 0;
  config.safety.max_force = 1e3;
  config.n_objects = 1;
  return config;
}

}  // namespace haptic::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/simulated_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kFlags = kDeviceFresh | kDeviceHomed | kDeviceSimulated;

/// Where the intent can be led: the device's workspace, or as far as an arm reaches.
Ball reach_of(const DeviceConfig& config) {
  constexpr double kArm = 0.7;  // [m]
  if (config.workspace_radius > 0) return {config.workspace_centre_B, config.workspace_radius};
  return {config.hand.intent.centre_B, kArm};
}

double quantised(double x, double step) {
  return step > 0 ? std::floor(x / step) * step : x;
}

}  // namespace

SimulatedHand::SimulatedHand(const DeviceConfig& config)
    : SimulatedHand(config, seeded_intention(config.hand)) {}

SimulatedHand::SimulatedHand(const DeviceConfig& config, Intention intention)
    : config_(config.hand),
      intention_(std::move(intention)),
      max_force_(config.max_force),
      reach_(reach_of(config)),
      plant_(start_plant(config.hand, intention_)) {}

DeviceCaps SimulatedHand::caps() const {
  return {.max_force = max_force_, .max_torque = 0, .open_loop = false, .simulated = true};
}

std::string SimulatedHand::description() const {
  return "SIMULATED hand, seed " + std::to_string(config_.seed) + ", closed loop";
}

bool SimulatedHand::read(const TickTime& tick, DeviceState& state) {
  const int64_t elapsed_ns = started_ ? tick.now_ns - last_.t_ns : 0;
  if (started_ && elapsed_ns <= 0) {
    state = last_;
    state.flags = (state.flags & ~uint32_t{kDeviceFresh}) | kDeviceHeld;
    return false;
  }
  move_on(elapsed_ns);
  const Vec3 p_B = encoder_position();
  Vec3 v_B;
  if (started_) {
    // backward difference over the time that passed, then one pole (implicit Euler)
    const double dt = 1e-9 * static_cast<double>(elapsed_ns);
    const double pole = 1 / (2 * std::numbers::pi * config_.velocity_cutoff);
    const Vec3 raw_B = (p_B - last_.X_BH.p) / dt;
    v_B = last_.V_BH.v + dt / (dt + pole) * (raw_B - last_.V_BH.v);
  }
  started_ = true;
  last_ = DeviceState{};
  last_.t_ns = tick.now_ns;
  last_.X_BH.p = p_B;
  last_.V_BH.v = v_B;
  last_.flags = kFlags | (saturated_ ? uint32_t{kDeviceSaturated} : 0) |
                (lost_time_ ? uint32_t{kDeviceLostTime} : 0) |
                (plant_.led.target_B ? uint32_t{kDeviceLed} : 0);
  state = last_;
  return true;
}

void SimulatedHand::write(const Wrench& F_B) {
  const double size = norm(F_B.f);
  saturated_ = !(size <= max_force_);
  held_force_B_ = F_B.f;
  if (!saturated_) return;
  held_force_B_ = std::isfinite(size) ? max_force_ / size * F_B.f : Vec3{};
}

void SimulatedHand::lead(const std::optional<Vec3>& p_BH) {
  if (config_.hand_stiffness <= 0) return;
  std::optional<Vec3> target_B;
  if (p_BH && is_finite(*p_BH)) target_B = nearest_in(reach_, *p_BH);
  lead_plant(intention_, plant_, target_B);
}

void SimulatedHand::stop() {
  write({});
}

void SimulatedHand::move_on(int64_t elapsed_ns) {
  HAPTIC_ASSERT(elapsed_ns >= 0);
  const int64_t lived_ns = std::min(elapsed_ns, kMaxCatchUpNs);
  lost_time_ = lived_ns < elapsed_ns;
  advance(config_, intention_, plant_, held_force_B_, lived_ns);
}

Vec3 SimulatedHand::encoder_position() const {
  const double step = config_.encoder_step;
  return {quantised(plant_.p_B.x, step), quantised(plant_.p_B.y, step),
          quantised(plant_.p_B.z, step)};
}

std::unique_ptr<Device> open_simulated_hand(const DeviceConfig& config, FileDescriptor) {
  return std::make_unique<SimulatedHand>(config);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/simulated_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "device-io/hand/portable_turn.h"
#include "device-io/sensing/saturate.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr uint32_t kFlags = kDeviceFresh | kDeviceHomed | kDeviceSimulated;

Vec3 quantised(const Vec3& a, double step) {
  if (!(step > 0)) return a;
  const auto below = [step](double x) { return std::floor(x / step) * step; };
  return {below(a.x), below(a.y), below(a.z)};
}

}  // namespace

Ball reach_of(const DeviceConfig& config) {
  constexpr double kArm = 0.7;  // [m]
  if (config.workspace_radius > 0) return {config.workspace_centre_B, config.workspace_radius};
  return {config.hand.intent.centre_B, kArm};
}

SimulatedHand::SimulatedHand(const DeviceConfig& config)
    : SimulatedHand(config, seeded_intention(config.hand)) {}

SimulatedHand::SimulatedHand(const DeviceConfig& config, Intention intention)
    : config_(config.hand),
      intention_(std::move(intention)),
      max_force_(config.max_force),
      max_torque_(can_turn(config.hand) ? config.max_torque : 0),
      reach_(reach_of(config)),
      plant_(start_plant(config.hand, intention_)) {}

DeviceCaps SimulatedHand::caps() const {
  return {
      .max_force = max_force_, .max_torque = max_torque_, .open_loop = false, .simulated = true};
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
  const Pose X_B = encoder_pose();
  Twist V_B;
  if (started_) {
    // backward difference over the time that passed, then one pole (implicit Euler)
    const double dt = 1e-9 * static_cast<double>(elapsed_ns);
    const double pole = 1 / (2 * std::numbers::pi * config_.velocity_cutoff);
    const double share = dt / (dt + pole);
    const Vec3 raw_B = (X_B.p - last_.X_BH.p) / dt;
    V_B.v = last_.V_BH.v + share * (raw_B - last_.V_BH.v);
    if (can_turn(config_)) {
      const Vec3 raw_w_B = portable_rotation_vector(X_B.q * conjugate(last_.X_BH.q)) / dt;
      V_B.w = last_.V_BH.w + share * (raw_w_B - last_.V_BH.w);
    }
  }
  started_ = true;
  last_ = DeviceState{};
  last_.t_ns = tick.now_ns;
  last_.X_BH = X_B;
  last_.V_BH = V_B;
  last_.flags = kFlags | (saturated_ ? uint32_t{kDeviceSaturated} : 0) |
                (lost_time_ ? uint32_t{kDeviceLostTime} : 0) |
                (plant_.led.target_B ? uint32_t{kDeviceLed} : 0);
  state = last_;
  return true;
}

void SimulatedHand::write(const Wrench& F_B) {
  held_B_ = F_B;
  if (!can_turn(config_)) held_B_.t = {};
  const bool force_cut = saturate(held_B_.f, max_force_);
  const bool torque_cut = saturate(held_B_.t, max_torque_);
  saturated_ = force_cut || torque_cut;
}

void SimulatedHand::lead(const std::optional<Pose>& X_BH) {
  if (config_.hand_stiffness <= 0) return;
  std::optional<Pose> target_B;
  if (X_BH && is_finite(*X_BH)) {
    target_B = Pose{nearest_in(reach_, X_BH->p), can_turn(config_) ? X_BH->q : Quat{}};
  }
  lead_plant(intention_, plant_, target_B);
}

void SimulatedHand::stop() {
  write({});
}

void SimulatedHand::move_on(int64_t elapsed_ns) {
  HAPTIC_ASSERT(elapsed_ns >= 0);
  const int64_t lived_ns = std::min(elapsed_ns, kMaxCatchUpNs);
  lost_time_ = lived_ns < elapsed_ns;
  advance(config_, intention_, plant_, held_B_, lived_ns);
}

Pose SimulatedHand::encoder_pose() const {
  Pose X_B{quantised(plant_.p_B, config_.encoder_step), {}};
  if (!can_turn(config_)) return X_B;
  // quantised or not, the same operations: exp(log q) is q to rounding
  X_B.q = portable_turn(quantised(portable_rotation_vector(plant_.q_B), config_.angle_step));
  return X_B;
}

std::unique_ptr<Device> open_simulated_hand(const DeviceConfig& config, FileDescriptor) {
  return std::make_unique<SimulatedHand>(config);
}

}  // namespace haptic

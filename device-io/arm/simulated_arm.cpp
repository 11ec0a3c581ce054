// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/arm/simulated_arm.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "device-io/hand/simulated_hand.h"
#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"

namespace haptic {
namespace {

constexpr uint32_t kFlags = kDeviceFresh | kDeviceHomed | kDeviceSimulated | kDeviceAdmittance;
constexpr int64_t kPartNs = 250'000;    // the hand's force is taken as linear for so long [ns]
constexpr int64_t kMostParts = 500;     // of one read; after a stall they are longer
constexpr int64_t kTickNs = 1'000'000;  // of the servo, until two reads have told [ns]

Pose pose_of(const Intent& intent) {
  return {intent.p_B, intent.q_B};
}

}  // namespace

SimulatedArm::SimulatedArm(const DeviceConfig& config)
    : SimulatedArm(config, seeded_intention(config.hand)) {}

SimulatedArm::SimulatedArm(const DeviceConfig& config, Intention intention)
    : hand_(config.hand),
      intention_(std::move(intention)),
      max_force_(config.max_force),
      max_torque_(config.max_torque),
      reach_(reach_of(config)),
      path_(std::llround(config.admittance.arm_delay * 1e9)) {
  X_B_ = intent_B_ = pose_of(intention_(0));
  path_.rest_at(X_B_);
}

DeviceCaps SimulatedArm::caps() const {
  return {.max_force = max_force_,
          .max_torque = max_torque_,
          .open_loop = false,
          .simulated = true,
          .causality = Causality::kAdmittance};
}

std::string SimulatedArm::description() const {
  return "SIMULATED arm that measures the hand's wrench, seed " + std::to_string(hand_.seed) +
         ", closed loop";
}

bool SimulatedArm::read(const TickTime& tick, DeviceState& state) {
  learn_tick(tick);
  const int64_t elapsed_ns = started_ ? tick.now_ns - last_.t_ns : 0;
  if (started_ && (elapsed_ns <= 0 || elapsed_ns < tick_ns_ / 2)) {
    state = last_;
    state.flags = (state.flags & ~uint32_t{kDeviceFresh}) | kDeviceHeld;
    return false;
  }
  const Pose before_B = X_B_;
  last_ = DeviceState{};
  if (started_) {
    live(elapsed_ns);
    last_.V_BH = 1e9 / static_cast<double>(elapsed_ns) * way_between(before_B, X_B_);
  }
  started_ = true;
  last_.t_ns = tick.now_ns;
  last_.X_BH = X_B_;
  last_.flags = kFlags | (led_.target_B ? uint32_t{kDeviceLed} : 0);
  state = last_;
  return true;
}

/// Skipped ticks leave gaps of several, so the shortest is one.
void SimulatedArm::learn_tick(const TickTime& tick) {
  const int64_t gap_ns = tick.deadline_ns - deadline_ns_;
  if (started_ && gap_ns > 0 && (tick_ns_ == 0 || gap_ns < tick_ns_)) tick_ns_ = gap_ns;
  if (!started_) start_ns_ = tick.now_ns;
  deadline_ns_ = tick.deadline_ns;
  late_ns_ = tick.now_ns - tick.deadline_ns;
}

void SimulatedArm::move(const Pose& X_BH) {
  if (!is_finite(X_BH)) return;
  // a command that is late, but not too late for the delay, is played as if it were not
  const int64_t missed_ns = std::max(late_ns_ - path_.delay_ns(), int64_t{0});
  const int64_t from_ns = std::max(deadline_ns_ - start_ns_ + missed_ns, int64_t{0});
  path_.go(from_ns, from_ns + (tick_ns_ > 0 ? tick_ns_ : kTickNs), {X_BH.p, normalized(X_BH.q)});
}

void SimulatedArm::lead(const std::optional<Pose>& X_BH) {
  if (hand_.hand_stiffness <= 0) return;
  std::optional<Pose> target_B;
  if (X_BH && is_finite(*X_BH)) target_B = Pose{nearest_in(reach_, X_BH->p), X_BH->q};
  if (target_B == led_.target_B) return;
  retarget(led_, target_B, intention_(1e-9 * static_cast<double>(t_ns_)));
}

void SimulatedArm::stop() {
  path_.rest_at(X_B_);
}

Pose SimulatedArm::next_intent(int64_t dt_ns) {
  const double h = 1e-9 * static_cast<double>(dt_ns);
  if (led_.target_B) return follow(led_, *led_.target_B, h);
  const Pose own_B = pose_of(intention_(1e-9 * static_cast<double>(t_ns_ + dt_ns)));
  return led_.is_away ? follow(led_, own_B, h) : own_B;
}

/// The hand's mean wrench over one part, which moves arm and intention on.
Wrench SimulatedArm::push(const Pose& X_to_B, const Pose& intent_to_B, double h) {
  HAPTIC_ASSERT(h > 0);
  const Twist V_B = 1 / h * way_between(X_B_, X_to_B);
  const Twist stretch = way_between(X_B_, intent_B_), stretch_to = way_between(X_to_B, intent_to_B);
  const Twist mean = 0.5 * (stretch + stretch_to), rate = 1 / h * (stretch_to - stretch);
  const Twist change = V_B - V_B_;
  const Vec3 spring = hand_.hand_stiffness * mean.v + hand_.hand_damping * rate.v;
  Wrench F{spring - hand_.hand_mass / h * change.v, {}};
  // the impulse of a change of speed works on the mean of the two
  work_.moving += h * dot(spring, V_B.v) - hand_.hand_mass * dot(change.v, V_B.v + V_B_.v) / 2;
  if (max_torque_ > 0) {
    const Vec3 twist =
        hand_.hand_rotational_stiffness * mean.w + hand_.hand_rotational_damping * rate.w;
    F.t = twist - hand_.hand_inertia / h * change.w;
    work_.turning += h * dot(twist, V_B.w) - hand_.hand_inertia * dot(change.w, V_B.w + V_B_.w) / 2;
  }
  X_B_ = X_to_B;
  V_B_ = V_B;
  intent_B_ = intent_to_B;
  return F;
}

void SimulatedArm::live(int64_t elapsed_ns) {
  const int64_t parts = std::clamp((elapsed_ns + kPartNs - 1) / kPartNs, int64_t{1}, kMostParts);
  const int64_t end_ns = t_ns_ + elapsed_ns;
  Wrench sum;
  for (int64_t i = 0; i < parts; ++i) {
    const int64_t dt_ns = (end_ns - t_ns_) / (parts - i);
    const Pose intent_B = next_intent(dt_ns);
    const double h = 1e-9 * static_cast<double>(dt_ns);
    sum = sum + h * push(path_.at(t_ns_ + dt_ns), intent_B, h);
    t_ns_ += dt_ns;
  }
  last_.F_hand_B = 1e9 / static_cast<double>(elapsed_ns) * sum;
}

std::unique_ptr<Device> open_simulated_arm(const DeviceConfig& config, FileDescriptor) {
  return std::make_unique<SimulatedArm>(config);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/passivity.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kForgetTime = 0.5;      // decay of a deficit in free space [s]
constexpr double kStill = 1e-3;          // slower than this there is nothing to damp [m/s]
constexpr double kStillTurning = 10e-3;  // the same for turning: 1 mm/s at 100 mm [rad/s]

/// One part of the port: force and velocity, or torque and angular velocity.
struct Part {
  Vec3 wanted, held, velocity;
  double max_damping = 0;
  double still = 0;  // speed below which it does not damp

  /// What is pushed along: on the way out the last push gives the direction, because a buzzing wall
  /// releases most of its energy there.
  const Vec3& push() const { return wanted != Vec3{} ? wanted : held; }
};

/// Share of a deficit that turning has made: of what is missing in both ledgers.
double share_of_turning(double moving, double turning) {
  const double missing = std::max(-moving, 0.0), turning_missing = std::max(-turning, 0.0);
  return turning_missing > 0 ? turning_missing / (missing + turning_missing) : 0;
}

/// A debt is bounded; what is forgiven is forgiven where it arose.
void bound_debt(PassivityState& state) {
  if (state.energy >= -kPassivityDebt) return;
  const double share = share_of_turning(state.energy - state.turning, state.turning);
  state.turning += share * (-kPassivityDebt - state.energy);
  state.energy = -kPassivityDebt;
}

/// In free space a surplus is dropped and a deficit decays; a surplus of one part that the other
/// has used up is gone as well.
void forget(PassivityState& state, double dt) {
  const double left = 1 - std::min(dt / kForgetTime, 1.0);
  const double deficit = std::min(state.energy, 0.0);
  state.turning = std::clamp(state.turning, deficit, 0.0) * left;
  state.energy = deficit * left;
}

/// Subtracts the work of the held wrench since the last sample. Returns the velocity of the handle
/// relative to the surface.
Twist observe(PassivityState& state, const PassivityInput& input, const Wrench& held_B, double dt) {
  const double since = 1e-9 * static_cast<double>(input.t_ns - state.t_ns);
  const Vec3 step_B = input.X_BH.p - state.X_BH.p - since * input.surface_B.v;
  const Vec3 turn_B =
      to_rotation_vector(input.X_BH.q * conjugate(state.X_BH.q)) - since * input.surface_B.w;
  const double turning = dot(held_B.t, turn_B);
  state.energy -= dot(held_B.f, step_B) + turning;
  state.turning -= turning;
  bound_debt(state);
  state.X_BH = input.X_BH;
  state.t_ns = input.t_ns;
  state.impulse_B = {};
  state.held = 0;
  // time stamps closer than a tick would give a wrong speed
  const double time = std::max(since, dt);
  return {step_B / time, turn_B / time};
}

/// The damper that dissipates a deficit in the coming tick, along the push only, so a smooth wall
/// stays smooth. It never pulls harder than was pushed.
Vec3 damper(const Part& part, double deficit, double dt) {
  const double push = norm(part.push());
  if (!(deficit > 0) || push == 0) return {};
  const Vec3 along = part.push() / push;
  const double speed = dot(part.velocity, along);
  if (std::fabs(speed) < part.still) return {};
  const double alpha = std::min(deficit / (dt * speed * speed), part.max_damping);
  const double most = std::max(push, norm(part.held));
  return std::min(alpha * speed, most) * along;
}

}  // namespace

PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt) {
  HAPTIC_ASSERT(dt > 0 && input.max_damping >= 0 && input.max_rotational_damping >= 0);
  HAPTIC_ASSERT(is_finite(input.F_B));
  PassivityOutput out{input.F_B};
  if (!state.known) {
    state.X_BH = input.X_BH;
    state.t_ns = input.t_ns;
    state.known = true;
    return out;
  }
  // without a new sample the work of the wrench is unknown
  if (input.t_ns <= state.t_ns) return out;
  const Wrench held_B = state.held > 0
                            ? Wrench{state.impulse_B.f / state.held, state.impulse_B.t / state.held}
                            : Wrench{};
  const Twist V_B = observe(state, input, held_B, dt);
  const Part moving{input.F_B.f, held_B.f, V_B.v, input.max_damping, kStill};
  const Part turning{input.F_B.t, held_B.t, V_B.w, input.max_rotational_damping, kStillTurning};
  if (moving.push() == Vec3{} && turning.push() == Vec3{}) {
    forget(state, dt);
    return out;
  }

  // energy after the coming tick, if the handle keeps its velocity
  const double work = dt * dot(moving.wanted, moving.velocity);
  const double turning_work = dt * dot(turning.wanted, turning.velocity);
  const double expected = state.energy - (work + turning_work);
  if (expected >= -kPassivitySlack) return out;
  const double deficit = -kPassivitySlack - expected;
  const double share =
      share_of_turning(state.energy - state.turning - work, state.turning - turning_work);
  const Vec3 brake_B = damper(moving, (1 - share) * deficit, dt);
  const Vec3 turning_brake_B = damper(turning, share * deficit, dt);
  out.damped = brake_B != Vec3{} || turning_brake_B != Vec3{};
  out.F_B = {input.F_B.f - brake_B, input.F_B.t - turning_brake_B};
  return out;
}

void note_held(PassivityState& state, const Wrench& held_B, double dt) {
  HAPTIC_ASSERT(dt > 0 && is_finite(held_B));
  state.impulse_B = state.impulse_B + dt * held_B;
  state.held += dt;
}

}  // namespace haptic

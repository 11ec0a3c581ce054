// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/passivity.h"

#include <algorithm>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kForgetTime = 0.5;  // decay of a deficit in free space [s]
constexpr double kStill = 1e-3;      // slower than this there is nothing to damp [m/s]

/// Subtracts the work of the held force since the last sample. Returns the velocity of the handle
/// relative to the surface.
Vec3 observe(PassivityState& state, const PassivityInput& input, const Vec3& held_B, double dt) {
  const double since = 1e-9 * static_cast<double>(input.t_ns - state.t_ns);
  const Vec3 step_B = input.p_B - state.p_B - since * input.surface_velocity_B;
  state.energy = std::max(state.energy - dot(held_B, step_B), -kPassivityDebt);
  state.p_B = input.p_B;
  state.t_ns = input.t_ns;
  state.impulse_B = {};
  state.held = 0;
  // time stamps closer than a tick would give a wrong speed
  return step_B / std::max(since, dt);
}

}  // namespace

PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt) {
  HAPTIC_ASSERT(dt > 0 && input.max_damping >= 0);
  HAPTIC_ASSERT(is_finite(input.force_B));
  PassivityOutput out{input.force_B};
  if (!state.known) {
    state.p_B = input.p_B;
    state.t_ns = input.t_ns;
    state.known = true;
    return out;
  }
  // without a new sample the work of the force is unknown
  if (input.t_ns <= state.t_ns) return out;
  const Vec3 held_B = state.held > 0 ? state.impulse_B / state.held : Vec3{};
  const Vec3 velocity_B = observe(state, input, held_B, dt);
  const Vec3& push_B = input.force_B != Vec3{} ? input.force_B : held_B;
  if (push_B == Vec3{}) {
    state.energy = std::min(state.energy, 0.0) * (1 - std::min(dt / kForgetTime, 1.0));
    return out;
  }

  // energy after the coming tick, if the handle keeps its velocity
  const double expected = state.energy - dt * dot(input.force_B, velocity_B);
  if (expected >= -kPassivitySlack) return out;
  // damps along the force only, so a smooth wall stays smooth. On the way out the last push gives
  // the direction: a buzzing wall releases most of its energy there
  const double push = norm(push_B);
  const Vec3 along_B = push_B / push;
  const double speed = dot(velocity_B, along_B);
  if (std::fabs(speed) < kStill) return out;
  const double alpha =
      std::min((-kPassivitySlack - expected) / (dt * speed * speed), input.max_damping);
  // never pulls harder than it pushed
  const double most = std::max(push, norm(held_B));
  out.force_B = input.force_B - std::min(alpha * speed, most) * along_B;
  out.damped = alpha > 0;
  return out;
}

void note_held(PassivityState& state, const Vec3& held_B, double dt) {
  HAPTIC_ASSERT(dt > 0 && is_finite(held_B));
  state.impulse_B += dt * held_B;
  state.held += dt;
}

}  // namespace haptic

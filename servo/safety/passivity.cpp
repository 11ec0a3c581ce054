// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/safety/passivity.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kForgetTime = 0.5;  // of a debt, in free space [s]
constexpr double kStill = 1e-3;      // below it there is nothing to damp [m/s]

/// The force held since the last sample, with the way it was held over. Returns the velocity of the
/// handle against the surface.
Vec3 observe(PassivityState& state, const PassivityInput& input, const Vec3& held_B, double dt) {
  const double since = 1e-9 * static_cast<double>(input.t_ns - state.t_ns);
  const Vec3 step_B = input.p_B - state.p_B - since * input.surface_velocity_B;
  state.energy = std::max(state.energy - dot(held_B, step_B), -kPassivityDebt);
  state.p_B = input.p_B;
  state.t_ns = input.t_ns;
  state.impulse_B = {};
  state.held = 0;
  // two samples may be closer than their time stamps know: no speed is made of that
  return step_B / std::max(since, dt);
}

}  // namespace

PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt) {
  PassivityOutput out{input.force_B};
  if (!state.known) {
    state.p_B = input.p_B;
    state.t_ns = input.t_ns;
    state.known = true;
    return out;
  }
  // no new sample: nothing is known of what the force has done
  if (input.t_ns <= state.t_ns) return out;
  const Vec3 held_B = state.held > 0 ? state.impulse_B / state.held : Vec3{};
  const Vec3 velocity_B = observe(state, input, held_B, dt);
  const Vec3& push_B = input.force_B != Vec3{} ? input.force_B : held_B;
  if (push_B == Vec3{}) {
    state.energy = std::min(state.energy, 0.0) * (1 - std::min(dt / kForgetTime, 1.0));
    return out;
  }

  // what the coming tick will bring if the handle goes on as it did
  const double expected = state.energy - dt * dot(input.force_B, velocity_B);
  if (expected >= -kPassivitySlack) return out;
  // along the force only, where the energy goes: a smooth wall stays smooth; as the handle leaves
  // the wall, along the force it leaves: there a buzzing wall gives most of its energy away
  const double push = norm(push_B);
  const Vec3 along_B = push_B / push;
  const double speed = dot(velocity_B, along_B);
  if (std::fabs(speed) < kStill) return out;
  const double alpha =
      std::min((-kPassivitySlack - expected) / (dt * speed * speed), input.max_damping);
  // pulls no more than it pushed before
  const double most = std::max(push, norm(held_B));
  out.force_B = input.force_B - std::min(alpha * speed, most) * along_B;
  out.damped = alpha > 0;
  return out;
}

void note_held(PassivityState& state, const Vec3& held_B, double dt) {
  state.impulse_B += dt * held_B;
  state.held += dt;
}

}  // namespace haptic

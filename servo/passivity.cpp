// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/passivity.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr double kForgetTime = 0.5;  // of a debt, in free space [s]
constexpr double kStill = 1e-6;      // of a way in one tick: below it nothing can be damped [m]

}  // namespace

PassivityOutput keep_passive(PassivityState& state, const PassivityInput& input, double dt) {
  PassivityOutput out{input.force_B};
  if (!state.known) return out;
  const Vec3 step_B = input.p_B - state.p_B - dt * input.surface_velocity_B;
  if (input.force_B == Vec3{} && state.held_B == Vec3{}) {
    state.energy = std::min(state.energy, 0.0) * (1 - std::min(dt / kForgetTime, 1.0));
    return out;
  }
  // the force that was held, with the way it was held over
  state.energy -= dot(state.held_B, step_B);
  state.energy = std::max(state.energy, -kPassivityDebt);

  // what the coming tick will bring if the handle goes on as it did
  const double expected = state.energy - dot(input.force_B, step_B);
  if (expected >= -kPassivitySlack) return out;
  // along the force only, where the energy goes: a smooth wall stays smooth; as the handle leaves
  // the wall, along the force it leaves: there a buzzing wall gives most of its energy away
  const Vec3 along_B = normalized(input.force_B != Vec3{} ? input.force_B : state.held_B);
  const double way = dot(step_B, along_B);
  if (std::fabs(way) < kStill) return out;
  const double alpha =
      std::min((-kPassivitySlack - expected) * dt / (way * way), input.max_damping);
  out.force_B = input.force_B - alpha * way / dt * along_B;
  out.damped = true;
  return out;
}

void note_held(PassivityState& state, const Vec3& p_B, const Vec3& held_B) {
  state.p_B = p_B;
  state.held_B = held_B;
  state.known = true;
}

}  // namespace haptic

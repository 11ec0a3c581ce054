// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/turning.h"

#include "device-io/hand/portable_turn.h"

namespace haptic {
namespace {

/// Half of what the rotation vector θ changes in a step beyond turn − intent_turn:
/// θ̇ = J_l⁻¹ ω − J_r⁻¹ ω_h = ω − ω_h − ½ θ×(ω + ω_h) + β θ×(θ×(ω − ω_h)).
Vec3 half_of_crossing(const Vec3& twist_B, const Vec3& turn_B, const Vec3& intent_turn_B) {
  const Vec3 bend_B = cross(twist_B, cross(twist_B, turn_B - intent_turn_B));
  return (turn_curvature(twist_B) * bend_B - 0.5 * cross(twist_B, turn_B + intent_turn_B)) / 2;
}

}  // namespace

TurningStep step_turning(const SimulatedHandConfig& c, const Turning& turning, double h) {
  const double inertia = c.inertia + c.hand_inertia;
  const Vec3 intent_B = turning.intent_turn_B;
  const Vec3 middle_B =
      turning.twist_B - intent_B / 2 + half_of_crossing(turning.twist_B, h * turning.w_B, intent_B);
  const Vec3 torque_B = turning.torque_B - c.hand_rotational_stiffness * middle_B +
                        c.hand_rotational_damping / h * intent_B;
  const Vec3 impulse_B = 2 * inertia * turning.w_B + h * torque_B;
  const double impulse = norm(impulse_B), friction = h * c.rotational_friction;
  TurningStep step{};
  if (impulse <= friction) {
    // sticks: friction absorbs the angular momentum and its kinetic energy
    step.device_loss = inertia * norm_squared(turning.w_B) / 2;
  } else {
    // mean angular velocity; all torques at the middle of the step
    const Vec3 mean_B = (1 - friction / impulse) * impulse_B /
                        (2 * inertia + h * (c.rotational_damping + c.hand_rotational_damping) +
                         h * h * c.hand_rotational_stiffness / 2);
    step.turn_B = h * mean_B;
    step.w_B = 2 * mean_B - turning.w_B;
    step.device_loss = friction * norm(mean_B) + h * c.rotational_damping * norm_squared(mean_B);
  }
  const Vec3 slip_B = step.turn_B - intent_B;
  step.on_hand_B = c.hand_rotational_stiffness * (middle_B + step.turn_B / 2) +
                   c.hand_rotational_damping / h * slip_B;
  step.hand_loss = c.hand_rotational_damping / h * norm_squared(slip_B);
  return step;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/plant.h"

#include <algorithm>
#include <cmath>

#include "device-io/hand/intent.h"
#include "device-io/hand/portable_turn.h"
#include "device-io/hand/turning.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// A device that nobody holds has no intention.
bool is_held(const SimulatedHandConfig& config) {
  return config.hand_stiffness > 0 || config.hand_damping > 0;
}

/// True if the hand acts on the handle's orientation.
bool is_twisted(const SimulatedHandConfig& config) {
  return can_turn(config) &&
         (config.hand_rotational_stiffness > 0 || config.hand_rotational_damping > 0);
}

Pose own_intent(const SimulatedHandConfig& config, const Intention& intention, double t) {
  Pose X_B;
  if (!is_held(config) && !is_twisted(config)) return X_B;
  const Intent intent = intention(t);
  if (is_held(config)) X_B.p = intent.p_B;
  if (is_twisted(config)) X_B.q = intent.q_B;
  return X_B;
}

/// The intended pose after another dt_ns.
Pose next_intent(const SimulatedHandConfig& config, const Intention& intention, HandPlant& plant,
                 int64_t dt_ns) {
  const double h = 1e-9 * static_cast<double>(dt_ns);
  if (plant.led.target_B) return follow(plant.led, *plant.led.target_B, h);
  const double t = 1e-9 * static_cast<double>(plant.t_ns + dt_ns);
  const Pose own_B = own_intent(config, intention, t);
  return plant.led.is_away ? follow(plant.led, own_B, h) : own_B;
}

/// Input of one axis for one step.
struct Axis {
  double force;        // of the device [N]
  double intent_step;  // motion of the intention [m]
  double stretch;      // x − x_h at the start [m]
  double velocity;     // at the start [m/s]
};

/// Displacement and final velocity of an axis. With the mean velocity u, v₁ = 2u − v₀ and all
/// forces at the middle of the step: u (2M + h(b + b_h) + h²k/2) = 2M v₀ + h F − J, J the friction
/// impulse.
struct AxisStep {
  double displacement, velocity, friction_loss;
};

AxisStep step_axis(const SimulatedHandConfig& c, const Axis& axis, double h) {
  const double mass = c.mass + c.hand_mass;
  const double intent_velocity = axis.intent_step / h;
  const double force = axis.force - c.hand_stiffness * (axis.stretch - axis.intent_step / 2) +
                       c.hand_damping * intent_velocity;
  const double impulse = 2 * mass * axis.velocity + h * force;
  const double friction = h * c.coulomb_friction;
  // sticks: friction absorbs the momentum and its kinetic energy
  if (std::fabs(impulse) <= friction) {
    return {0, 0, mass * axis.velocity * axis.velocity / 2};
  }
  const double u = (impulse - std::copysign(friction, impulse)) /
                   (2 * mass + h * (c.damping + c.hand_damping) + h * h * c.hand_stiffness / 2);
  return {h * u, 2 * u - axis.velocity, friction * std::fabs(u)};
}

void account(const SimulatedHandConfig& c, const Axis& axis, const AxisStep& step, double h,
             HandEnergy& energy) {
  const double slip = step.displacement - axis.intent_step;
  const double on_hand = c.hand_stiffness * (axis.stretch + slip / 2) + c.hand_damping * slip / h;
  energy.device_work += axis.force * step.displacement;
  energy.intention_work -= on_hand * axis.intent_step;
  energy.device_loss += c.damping * step.displacement * step.displacement / h + step.friction_loss;
  energy.hand_loss += c.hand_damping * slip * slip / h;
}

/// The axes of position, over one step.
void move(const SimulatedHandConfig& config, const Vec3& force_B, const Vec3& intent_B, double h,
          HandPlant& plant) {
  for (int k = 0; k < 3; ++k) {
    const Axis axis{force_B[k], intent_B[k] - plant.intent_B[k], plant.p_B[k] - plant.intent_B[k],
                    plant.v_B[k]};
    const AxisStep step = step_axis(config, axis, h);
    account(config, axis, step, h, plant.energy);
    plant.p_B[k] += step.displacement;
    plant.v_B[k] = step.velocity;
  }
  plant.intent_B = intent_B;
}

/// The orientation, over one step in which the intended one turns by `turn_B` to `intent_q_B`.
void turn(const SimulatedHandConfig& config, const Vec3& torque_B, const Vec3& turn_B,
          const Quat& intent_q_B, double h, HandPlant& plant) {
  const Vec3 twist_B = portable_rotation_vector(plant.q_B * conjugate(plant.intent_q_B));
  const TurningStep step = step_turning(config, {torque_B, twist_B, plant.w_B, turn_B}, h);
  plant.energy.device_work += dot(torque_B, step.turn_B);
  plant.energy.intention_work -= dot(step.on_hand_B, turn_B);
  plant.energy.device_loss += step.device_loss;
  plant.energy.hand_loss += step.hand_loss;
  if (step.turn_B != Vec3{}) plant.q_B = normalized(portable_turn(step.turn_B) * plant.q_B);
  plant.w_B = step.w_B;
  plant.intent_q_B = intent_q_B;
}

/// Equal steps, over which the intention moves on a straight line and turns about one axis.
void advance_straight(const SimulatedHandConfig& config, const Intention& intention,
                      HandPlant& plant, const Wrench& F_B, int64_t dt_ns) {
  const int64_t steps = (dt_ns + kPlantStepNs - 1) / kPlantStepNs;
  const double h = 1e-9 * static_cast<double>(dt_ns) / static_cast<double>(steps);
  const Vec3 from_B = plant.intent_B;
  const Pose to_B = next_intent(config, intention, plant, dt_ns);
  Vec3 turn_B;
  if (is_twisted(config)) {
    turn_B =
        portable_rotation_vector(to_B.q * conjugate(plant.intent_q_B)) / static_cast<double>(steps);
  }
  const Quat q_step = portable_turn(turn_B);
  for (int64_t i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(steps);
    move(config, F_B.f, i == steps ? to_B.p : from_B + share * (to_B.p - from_B), h, plant);
    if (!can_turn(config)) continue;
    turn(config, F_B.t, turn_B, i == steps ? to_B.q : q_step * plant.intent_q_B, h, plant);
  }
  plant.t_ns += dt_ns;
}

}  // namespace

Intention seeded_intention(const SimulatedHandConfig& config) {
  return
      [intent = config.intent, seed = config.seed](double t) { return intent_at(intent, seed, t); };
}

bool can_turn(const SimulatedHandConfig& config) {
  return config.inertia > 0;
}

HandPlant start_plant(const SimulatedHandConfig& config) {
  return start_plant(config, seeded_intention(config));
}

HandPlant start_plant(const SimulatedHandConfig& config, const Intention& intention) {
  HandPlant plant;
  const Pose intent_B = own_intent(config, intention, 0);
  plant.p_B = plant.intent_B = intent_B.p;
  plant.q_B = plant.intent_q_B = intent_B.q;
  return plant;
}

void lead_plant(const Intention& intention, HandPlant& plant, const std::optional<Pose>& target_B) {
  if (target_B == plant.led.target_B) return;
  retarget(plant.led, target_B, intention(1e-9 * static_cast<double>(plant.t_ns)));
}

void advance(const SimulatedHandConfig& config, HandPlant& plant, const Wrench& F_B,
             int64_t dt_ns) {
  advance(config, seeded_intention(config), plant, F_B, dt_ns);
}

void advance(const SimulatedHandConfig& config, const Intention& intention, HandPlant& plant,
             const Wrench& F_B, int64_t dt_ns) {
  HAPTIC_ASSERT(dt_ns >= 0);
  HAPTIC_ASSERT(config.mass + config.hand_mass > 0 && config.coulomb_friction >= 0);
  HAPTIC_ASSERT(config.inertia >= 0 && config.rotational_friction >= 0);
  HAPTIC_ASSERT(is_finite(F_B));
  for (int64_t left_ns = dt_ns; left_ns > 0;) {
    const int64_t piece_ns = std::min(left_ns, kIntentStepNs);
    advance_straight(config, intention, plant, F_B, piece_ns);
    left_ns -= piece_ns;
  }
}

double mechanical_energy(const SimulatedHandConfig& config, const HandPlant& plant) {
  const double mass = config.mass + config.hand_mass;
  const double moving = mass * norm_squared(plant.v_B) / 2 +
                        config.hand_stiffness * norm_squared(plant.p_B - plant.intent_B) / 2;
  if (!can_turn(config)) return moving;
  const Vec3 twist_B = portable_rotation_vector(plant.q_B * conjugate(plant.intent_q_B));
  return moving + (config.inertia + config.hand_inertia) * norm_squared(plant.w_B) / 2 +
         config.hand_rotational_stiffness * norm_squared(twist_B) / 2;
}

}  // namespace haptic

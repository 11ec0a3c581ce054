// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/plant.h"

#include <algorithm>
#include <cmath>

#include "device-io/hand/intent.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

/// A device that nobody holds has no intention.
bool is_held(const SimulatedHandConfig& config) {
  return config.hand_stiffness > 0 || config.hand_damping > 0;
}

Vec3 intent_position(const SimulatedHandConfig& config, const Intention& intention, double t) {
  return is_held(config) ? intention(t).p_B : Vec3{};
}

/// x_h after another dt_ns.
Vec3 next_intent(const SimulatedHandConfig& config, const Intention& intention, HandPlant& plant,
                 int64_t dt_ns) {
  const double h = 1e-9 * static_cast<double>(dt_ns);
  if (plant.led.target_B) return follow(plant.led, *plant.led.target_B, h);
  const double t = 1e-9 * static_cast<double>(plant.t_ns + dt_ns);
  const Vec3 own_B = intent_position(config, intention, t);
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

/// Equal steps, over which the intention moves on a straight line.
void advance_straight(const SimulatedHandConfig& config, const Intention& intention,
                      HandPlant& plant, const Vec3& force_B, int64_t dt_ns) {
  const int64_t steps = (dt_ns + kPlantStepNs - 1) / kPlantStepNs;
  const double h = 1e-9 * static_cast<double>(dt_ns) / static_cast<double>(steps);
  const Vec3 from_B = plant.intent_B;
  const Vec3 to_B = next_intent(config, intention, plant, dt_ns);
  for (int64_t i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(steps);
    const Vec3 intent_B = i == steps ? to_B : from_B + share * (to_B - from_B);
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
  plant.t_ns += dt_ns;
}

}  // namespace

Intention seeded_intention(const SimulatedHandConfig& config) {
  return
      [intent = config.intent, seed = config.seed](double t) { return intent_at(intent, seed, t); };
}

HandPlant start_plant(const SimulatedHandConfig& config) {
  return start_plant(config, seeded_intention(config));
}

HandPlant start_plant(const SimulatedHandConfig& config, const Intention& intention) {
  HandPlant plant;
  plant.intent_B = intent_position(config, intention, 0);
  plant.p_B = plant.intent_B;
  return plant;
}

void lead_plant(const Intention& intention, HandPlant& plant, const std::optional<Vec3>& target_B) {
  if (target_B == plant.led.target_B) return;
  retarget(plant.led, target_B, intention(1e-9 * static_cast<double>(plant.t_ns)));
}

void advance(const SimulatedHandConfig& config, HandPlant& plant, const Vec3& force_B,
             int64_t dt_ns) {
  advance(config, seeded_intention(config), plant, force_B, dt_ns);
}

void advance(const SimulatedHandConfig& config, const Intention& intention, HandPlant& plant,
             const Vec3& force_B, int64_t dt_ns) {
  HAPTIC_ASSERT(dt_ns >= 0);
  HAPTIC_ASSERT(config.mass + config.hand_mass > 0 && config.coulomb_friction >= 0);
  HAPTIC_ASSERT(is_finite(force_B));
  for (int64_t left_ns = dt_ns; left_ns > 0;) {
    const int64_t piece_ns = std::min(left_ns, kIntentStepNs);
    advance_straight(config, intention, plant, force_B, piece_ns);
    left_ns -= piece_ns;
  }
}

double mechanical_energy(const SimulatedHandConfig& config, const HandPlant& plant) {
  const double mass = config.mass + config.hand_mass;
  return mass * norm_squared(plant.v_B) / 2 +
         config.hand_stiffness * norm_squared(plant.p_B - plant.intent_B) / 2;
}

}  // namespace haptic

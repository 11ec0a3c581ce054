// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>

#include "device-io/hand/led_intent.h"
#include "proto/config/config.h"
#include "proto/math/pose.h"

namespace haptic {

/// Longest integration step of the plant [ns]: 1/50 of the period at 1 kHz.
inline constexpr int64_t kPlantStepNs = 20'000;

/// The intention is computed this often and moves on a straight line in between [ns]: a tick at 1
/// kHz. It costs more than all steps of a tick; a stroke of 1 m/s² bends by 0.1 µm in that time.
inline constexpr int64_t kIntentStepNs = 1'000'000;

/// The energy of the plant by where it came from and went [J], since the start; moving and turning
/// together.
struct HandEnergy {
  double device_work = 0;     // by the wrench on the device; negative: absorbed by the wall
  double intention_work = 0;  // by the intended motion, through the hand's springs and dampers
  double device_loss = 0;     // in the device's damping and friction; never decreases
  double hand_loss = 0;       // in the hand's dampers; never decreases
};

/// A device held by a hand, without electronics; per axis
///   m ẍ + b ẋ + f_c sgn ẋ = F_d + F_h,  F_h = −k_h (x − x_h) − b_h (ẋ − ẋ_h) − m_h ẍ
/// with the intention x_h(t) of intent_at, and where the handle has an inertia it turns likewise
/// (turning.h). Everything in the device's base frame; moving and turning do not act on each other,
/// as with an arm whose wrist is at the handle.
struct HandPlant {
  int64_t t_ns = 0;  // since the start
  Vec3 p_B;          // [m]
  Vec3 v_B;          // [m/s]
  Vec3 intent_B;     // x_h at t_ns; zero if no hand holds the device
  Quat q_B;          // orientation of the handle
  Vec3 w_B;          // its angular velocity [rad/s]
  Quat intent_q_B;   // intended orientation at t_ns; the identity if no hand holds it
  HandEnergy energy;
  LedIntent led;  // away from the intention while somebody leads
};

/// Intended motion at time t since the start [s], in the device's base frame; continuous.
using Intention = std::function<Intent(double t)>;
/// That of config.intent.
Intention seeded_intention(const SimulatedHandConfig& config);

/// All else that pulls at a handle: the weight of its arm, a stand that it lies on. None: nothing.
using PlantLoad = std::function<Wrench(const HandPlant& plant)>;
inline Wrench with_load(const Wrench& F_B, const PlantLoad& load, const HandPlant& plant) {
  return load ? F_B + load(plant) : F_B;
}

/// True if the handle turns at all.
bool can_turn(const SimulatedHandConfig& config);

/// At rest at the start of the intention.
HandPlant start_plant(const SimulatedHandConfig& config);
HandPlant start_plant(const SimulatedHandConfig& config, const Intention& intention);

/// From now on the intent goes to that pose in B (led_intent.h); none: back to its own motion.
void lead_plant(const Intention& intention, HandPlant& plant, const std::optional<Pose>& target_B);

/// Moves the plant on by dt_ns under a constant wrench on the device, in steps of at most
/// kPlantStepNs, equal within each kIntentStepNs. Implicit midpoint rule, solved in closed form; an
/// axis whose momentum friction can absorb within a step sticks. Second order; without friction it
/// neither makes nor loses energy, so that it does not shift the stability limit of a sampled wall
/// (semi-implicit Euler at the same step: 2 % too stiff). Exactly, whatever the step: change of
/// mechanical_energy = device_work + intention_work − device_loss − hand_loss, while the handle
/// turns about one axis; where the axes of handle and intention differ, the sum is off by the
/// square of the step (by 1e-9 of the energy turned over).
void advance(const SimulatedHandConfig& config, HandPlant& plant, const Wrench& F_B, int64_t dt_ns);
/// A plant with another intention than that of the config.
void advance(const SimulatedHandConfig& config, const Intention& intention, HandPlant& plant,
             const Wrench& F_B, int64_t dt_ns);

/// Kinetic energy plus that of the hand's springs [J].
double mechanical_energy(const SimulatedHandConfig& config, const HandPlant& plant);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
// Peg, gears and rigid peg in closed loop with hands that move and turn. The plant alone is judged:
// its work, from its own steps, and its motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "clients/lab/stability/probe.h"
#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/hand/impedance.h"
#include "device-io/hand/intent.h"
#include "proto/config/coupling_margin.h"
#include "tests/clients/lab/support/hand_energy.h"
#include "tests/support/data.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using namespace test;

/// The wrench on a handle in nobody's hand: along x it shakes it where it is, and turns it at other
/// frequencies; while the others stand still it presses it.
Wrench shake(double t) {
  if (t > kStandsFrom && t < kStandsFrom + kHeld) return {{-0.2, 0, 0}, {0, 0, 1e-3}};
  const double w = 2 * std::numbers::pi * t;
  return {{-0.2 * std::sin(1.1 * w), 0, 0},
          0.01 * Vec3{std::sin(1.3 * w), std::cos(0.8 * w), std::sin(w)}};
}

/// All that hold, by HAPTIC_TORTURE_SCALE=2; in CI the lightest.
std::vector<HandImpedance> hands() {
  std::vector<HandImpedance> all = played_hands();
  std::erase_if(all, [](const HandImpedance& hand) { return hand.stiffness == 0; });
  return all;
}

Run play(const SessionConfig& config, const ContactShapes& shapes, bool is_held) {
  PushedHand hand(config.device, pausing(config.device.hand), 0);
  Lockstep lockstep(config, shapes, hand);
  Run run;
  double pushed = 0;
  Wrench push;
  Pose before{hand.plant().p_B, hand.plant().q_B};
  for (size_t k = 0; k < kTicks; ++k) {
    if (!is_held) hand.push_B = shake(static_cast<double>(k) / kSecond);
    REQUIRE(lockstep.step());
    const HandPlant& plant = hand.plant();
    // what shakes the handle is no motor; it was held over the last tick
    const Pose now{plant.p_B, plant.q_B};
    pushed += dot(push.f, now.p - before.p) +
              dot(push.t, to_rotation_vector(now.q * conjugate(before.q)));
    push = hand.push_B;
    before = now;
    run.note(config, config.device.hand, plant, lockstep.frame(), pushed);
  }
  return run;
}

/// A shipped scene whose force begins at once and is left to the coupling: no controller takes
/// energy out of it.
struct Scene {
  explicit Scene(const std::string& name)
      : config(adapted(load_config(test::from_source("configs/" + name + ".toml")))),
        baked(bake_session(config)) {}
  SessionConfig config;
  BakedSession baked;
  bool rolls = false;  // what nobody holds does not come to rest

 private:
  static SessionConfig adapted(SessionConfig config) {
    config.device.max_damping = config.device.max_rotational_damping = 0;
    config.safety.soft_start = 0;
    return config;
  }
};

/// True if no hand can make the coupling unstable: it is below 2 (b − b_c)/T and 2c/Δ, moving and
/// turning.
bool is_safe(const SessionConfig& config) {
  const SimulatedHandConfig& hand = config.device.hand;
  const Coupling& k = config.coupling;
  return k.translational_stiffness < passive_stiffness(moving_axis(config)) &&
         k.rotational_stiffness < passive_stiffness(turning_axis(config)) &&
         k.translational_stiffness <= 2 * hand.coulomb_friction / hand.encoder_step &&
         k.rotational_stiffness <= 2 * hand.rotational_friction / hand.angle_step;
}

Run play_in(const Scene& scene, const HandImpedance& hand) {
  SessionConfig config = scene.config;
  put_under(config.device.hand, hand);
  return play(config, scene.baked.shapes(), hand.stiffness > 0);
}

void check(const Scene& scene, const HandImpedance& hand) {
  CAPTURE(hand.name);
  const Run run = play_in(scene, hand);
  REQUIRE(is_safe(scene.config));
  CHECK(run.touching > kTicks / 10);
  CHECK(run.force > 0.3);
  CHECK(run.torque > 3e-3);
  CHECK(gained(run) <= 0);
  // a gear that nobody holds rolls on the other
  if (hand.stiffness == 0 && scene.rolls) return;
  // one count of an encoder at 100 Hz is 1e-11 J in the lightest hand
  CHECK(largest_kinetic(run, 7) <= 0.01 * largest_kinetic(run, 0) + 1e-11);
}

}  // namespace

TEST_CASE("closed loop: a peg that five hands move and turn in its hole", "[lab]") {
  Scene scene("peg-in-hole");
  for (const HandImpedance& hand : kHandImpedances) check(scene, hand);
  if (torture_scale() == 1) return;
  // just inside of what friction and encoder allow
  scene.config.coupling.translational_stiffness = 1900;
  scene.config.coupling.rotational_stiffness = 4.8;
  for (const HandImpedance& hand : hands()) check(scene, hand);
}

TEST_CASE("closed loop: a gear that is moved and turned in the teeth of another", "[lab]") {
  Scene scene("gears");
  for (const HandImpedance& hand : hands()) check(scene, hand);
  // without a hand it begins where the tips are in the gaps
  scene.config.map.X_WB.p = {0.06005, 0, 0};
  scene.rolls = true;
  check(scene, kHandImpedances[0]);
}

TEST_CASE("closed loop: a peg that never enters the wall of its hole", "[lab]") {
  Scene scene("rigid-peg");
  if (test::torture_scale() > 1) check(scene, kHandImpedances[0]);
  for (const HandImpedance& hand : hands()) check(scene, hand);
  // a coupling that is too stiff is seen to ring, and to give
  scene.config.coupling.translational_stiffness = 20e3;
  scene.config.coupling.rotational_stiffness = 60;
  REQUIRE_FALSE(is_safe(scene.config));
  const Run run = play_in(scene, *find_hand("light-grip"));
  CHECK(gained(run) > 0);
  CHECK(largest_kinetic(run, 7) > 0.1 * largest_kinetic(run, 0));
}

}  // namespace haptic

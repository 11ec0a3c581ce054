// SPDX-License-Identifier: GPL-3.0-or-later
// A handle that turns: device-io/hand/turning.cpp through the plant, and portable_turn.cpp.
#include "device-io/hand/turning.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "device-io/hand/plant.h"
#include "device-io/hand/portable_turn.h"
#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::tol;

namespace {

const Vec3 kOblique = normalized(Vec3{0.3, -0.5, 0.7});

/// Inertia and damper only: no hand, no friction, no encoder.
SimulatedHandConfig bare_handle(double inertia, double damping) {
  SimulatedHandConfig config;
  config.inertia = inertia;
  config.rotational_damping = damping;
  config.rotational_friction = 0;
  config.angle_step = 0;
  config.hand_inertia = config.hand_rotational_damping = config.hand_rotational_stiffness = 0;
  config.hand_mass = config.hand_damping = config.hand_stiffness = 0;
  return config;
}

/// An intention that stands still, or turns on at a constant angular velocity.
Intention spinning(const Vec3& w_B) {
  return [w_B](double t) { return Intent{{}, {}, from_rotation_vector(t * w_B), w_B}; };
}

double angle_about(const Vec3& axis_B, const Quat& q) {
  return dot(axis_B, to_rotation_vector(q));
}

double ledger_gap(const SimulatedHandConfig& config, const HandPlant& plant, double before) {
  const HandEnergy& e = plant.energy;
  return e.device_work + e.intention_work - e.device_loss - e.hand_loss -
         (mechanical_energy(config, plant) - before);
}

}  // namespace

TEST_CASE("portable turn: as with the library's functions, to rounding", "[device-io]") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> exponent(-10, 0.497);  // up to π
  for (int i = 0; i < 2000; ++i) {
    const Vec3 axis = normalized(Vec3{normal(random), normal(random), normal(random)});
    const double angle = std::pow(10, exponent(random));
    const Quat q = portable_turn(angle * axis), exact = from_rotation_vector(angle * axis);
    REQUIRE_THAT(q.vector(), IsNear(exact.vector(), 1e-15));
    REQUIRE(std::fabs(q.w - exact.w) <= tol(1e-15));
    REQUIRE_THAT(portable_rotation_vector(exact), IsNear(to_rotation_vector(exact), 4e-15));
    const Quat opposite{-exact.x, -exact.y, -exact.z, -exact.w};
    REQUIRE(portable_rotation_vector(opposite) == portable_rotation_vector(exact));
  }
  CHECK(portable_turn({}) == Quat{});
  CHECK(portable_rotation_vector({}) == Vec3{});
}

TEST_CASE("portable turn: rate and angular velocity are those of a difference quotient",
          "[device-io]") {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const auto any = [&] { return Vec3{normal(random), normal(random), normal(random)}; };
    const Vec3 axis = normalized(any()), rate = any();
    const Vec3 turn = (i % 2 == 0 ? 0.01 : 2.5) * std::fabs(std::sin(i)) * axis;
    constexpr double kStep = 1e-5;
    const Quat to = from_rotation_vector(turn + kStep * rate);
    const Quat from = from_rotation_vector(turn - kStep * rate);
    const Vec3 w = to_rotation_vector(to * conjugate(from)) / (2 * kStep);
    // second order in the step, and rounding over it
    REQUIRE_THAT(angular_velocity_of(turn, rate), IsNear(w, 1e-8));
    REQUIRE_THAT(rotation_vector_rate(turn, angular_velocity_of(turn, rate)), IsNear(rate, 1e-12));
  }
}

TEST_CASE("turning: with axes that differ the motion and its energy are of second order",
          "[device-io]") {
  // the handle swings about one axis while the hand turns about another
  SimulatedHandConfig config = bare_handle(1e-4, 2e-4);
  config.hand_rotational_stiffness = 0.5;
  config.hand_rotational_damping = 2e-4;
  const Intention intention = spinning({0, 3, 1});
  struct End {
    Quat q;
    double gap, turned_over;
  };
  const auto end = [&](int64_t chunk_ns) {
    HandPlant plant = start_plant(config, intention);
    plant.q_B = from_rotation_vector({0.8, 0, 0});
    plant.w_B = {0, 0, 20};
    const double before = mechanical_energy(config, plant);
    for (int64_t t = 0; t < 200 * kMs; t += chunk_ns) {
      advance(config, intention, plant, {}, chunk_ns);
    }
    return End{plant.q_B, ledger_gap(config, plant, before),
               plant.energy.device_loss + plant.energy.hand_loss};
  };
  const End coarse = end(20'000), fine = end(10'000), finest = end(2'500);
  const auto error = [&](const End& run) {
    return norm(to_rotation_vector(run.q * conjugate(finest.q)));
  };
  CAPTURE(error(coarse), error(fine), coarse.gap, fine.gap, coarse.turned_over);
  CHECK(error(coarse) < 1e-4);
  // (20² − 2.5²)/(10² − 2.5²)
  CHECK(error(coarse) / error(fine) == Approx(4.2).epsilon(0.05));
  CHECK(std::fabs(coarse.gap / fine.gap) == Approx(4).epsilon(0.2));
  CHECK(std::fabs(coarse.gap) < 1e-5 * coarse.turned_over);
}

TEST_CASE("turning: about one axis the energy ledger closes to rounding, friction and wall too",
          "[device-io]") {
  SimulatedHandConfig config = bare_handle(1e-4, 2e-3);
  config.rotational_friction = GENERATE(0.0, 1e-3, 1e-2);
  config.hand_inertia = 1e-3;
  config.hand_rotational_damping = GENERATE(0.0, 0.02);
  config.hand_rotational_stiffness = 2;
  config.intent.turn_angle = 0.6;
  config.intent.turn_axis_B = kOblique;
  HandPlant plant = start_plant(config);
  plant.w_B = 2 * kOblique;
  const double before = mechanical_energy(config, plant);
  double lost = 0;
  for (int k = 0; k < 3000; ++k) {
    const double angle = angle_about(kOblique, plant.q_B);
    const double depth = std::max(0.0, std::fabs(angle) - 0.3);
    advance(config, plant, {{}, -std::copysign(2 * depth, angle) * kOblique}, kMs);
    const double now_lost = plant.energy.device_loss + plant.energy.hand_loss;
    REQUIRE(now_lost >= lost);
    lost = now_lost;
  }
  CAPTURE(plant.energy.device_work, plant.energy.intention_work, lost);
  REQUIRE(plant.energy.intention_work > 1e-3);
  // 150 000 steps of roundings of 1e-17 J
  CHECK(std::fabs(ledger_gap(config, plant, before)) <= tol(1e-11));
}

TEST_CASE("turning: no axis is special", "[device-io]") {
  // a session turned as a whole gives the states turned
  const Quat q_AB = from_rotation_vector({0.7, -1.1, 0.4});
  SimulatedHandConfig config = bare_handle(1e-4, 1e-3);
  config.rotational_friction = 1e-3;
  config.hand_rotational_stiffness = 1;
  config.hand_rotational_damping = 1e-3;
  const Vec3 spin{1, 2, -0.5}, torque{0.01, -0.02, 0.005};
  HandPlant straight = start_plant(config, spinning(spin));
  HandPlant turned = start_plant(config, spinning(rotate(q_AB, spin)));
  for (int k = 0; k < 300; ++k) {
    advance(config, spinning(spin), straight, {{}, torque}, kMs);
    advance(config, spinning(rotate(q_AB, spin)), turned, {{}, rotate(q_AB, torque)}, kMs);
    REQUIRE_THAT(turned.w_B, IsNear(rotate(q_AB, straight.w_B), 1e-9));
    const Vec3 there = rotate(q_AB, to_rotation_vector(straight.q_B));
    REQUIRE_THAT(to_rotation_vector(turned.q_B), IsNear(there, 1e-10));
  }
}

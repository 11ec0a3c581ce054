// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hand/plant.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <numbers>
#include <vector>

#include "proto/math/units.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::IsNear;
using haptic::test::kAlgebra;
using haptic::test::tol;

namespace {

/// A way that a handle moves on or turns about. Turning has a thousandth of everything, so that the
/// numbers of its motion are the same.
struct Axis {
  bool turns = false;
  Vec3 along_B{1, 0, 0};

  double scale() const { return turns ? 1e-3 : 1; }
  Vec3 place(const HandPlant& plant) const {
    return turns ? to_rotation_vector(plant.q_B) : plant.p_B;
  }
  Vec3 velocity(const HandPlant& plant) const { return turns ? plant.w_B : plant.v_B; }
  Wrench push(const Vec3& force) const {
    return turns ? Wrench{{}, scale() * force} : Wrench{force, {}};
  }
  HandPlant at(double x, double v) const {
    HandPlant plant;
    if (turns) {
      plant.q_B = from_rotation_vector(x * along_B);
      plant.w_B = v * along_B;
    } else {
      plant.p_B = x * along_B;
      plant.v_B = v * along_B;
    }
    return plant;
  }
};
const std::vector<Axis> kAxes{
    {}, {true, {1, 0, 0}}, {true, {0, 0, -1}}, {true, normalized(Vec3{0.3, -0.5, 0.7})}};

/// Mass, damper and friction only: no hand, no encoder.
SimulatedHandConfig bare_device(double mass, double damping, double friction = 0,
                                const Axis& axis = {}) {
  SimulatedHandConfig config;
  config.mass = mass;
  config.damping = damping;
  config.coulomb_friction = friction;
  config.inertia = axis.turns ? axis.scale() * mass : 0;
  config.rotational_damping = axis.scale() * damping;
  config.rotational_friction = axis.scale() * friction;
  config.encoder_step = config.angle_step = 0;
  config.hand_mass = config.hand_damping = config.hand_stiffness = 0;
  config.hand_inertia = config.hand_rotational_damping = config.hand_rotational_stiffness = 0;
  return config;
}

struct SampledWall {
  double stiffness, damping;
  int64_t period_ns;
  int delay = 0;       // whole samples from measurement to force
  double encoder = 0;  // position quantum [m]
};

/// A bilateral wall at x = 0, as rendered by a servo: sampled, held, backward difference.
class WallLoop {
 public:
  WallLoop(const SimulatedHandConfig& device, const SampledWall& wall, double x, double v,
           const Axis& axis = {})
      : plant(axis.at(x, v)),
        device_(device),
        wall_(wall),
        axis_(axis),
        queue_(static_cast<size_t>(wall.delay), 0.0) {
    last_ = measure();
  }
  /// One period; returns the force held over it.
  double step() {
    const double x = measure();
    const double rate = (x - last_) / (1e-9 * static_cast<double>(wall_.period_ns));
    last_ = x;
    queue_.push_back(-(wall_.stiffness * x + wall_.damping * rate));
    const double held = queue_.front();
    queue_.pop_front();
    advance(device_, plant, axis_.push(held * axis_.along_B), wall_.period_ns);
    return held;
  }
  double place() const { return dot(axis_.along_B, axis_.place(plant)); }
  HandPlant plant;

 private:
  double measure() const {
    const double x = place();
    return wall_.encoder > 0 ? std::floor(x / wall_.encoder) * wall_.encoder : x;
  }
  SimulatedHandConfig device_;
  SampledWall wall_;
  Axis axis_;
  std::deque<double> queue_;
  double last_ = 0;
};

/// Largest |x| in the last quarter of the run relative to that in the second quarter: above one, it
/// grows.
double growth(WallLoop loop, int periods) {
  double second = 0, last = 0;
  for (int k = 0; k < periods; ++k) {
    loop.step();
    const double x = std::fabs(loop.place());
    // already diverged
    if (x > 1) return 1e9;
    if (k >= periods / 4 && k < periods / 2) second = std::max(second, x);
    if (k >= periods * 3 / 4) last = std::max(last, x);
  }
  return second > 0 ? last / second : 0;
}

}  // namespace

TEST_CASE("hand plant: a constant force gives the closed-form motion", "[device-io]") {
  const Axis axis = GENERATE(from_range(kAxes));
  const double m = 0.1, b = 0.8, F = 2, v0 = -0.3, t = 0.25;
  HandPlant plant = axis.at(0, v0);
  advance(bare_device(m, b, 0, axis), plant, axis.push(F * axis.along_B), 250 * kMs);
  const double decay = std::exp(-b * t / m), rest = F / b;
  // second order: (h b/m)²·t·b/m/12 of the exponential is 4e-9
  constexpr double kIntegrator = 2e-8;
  CHECK_THAT(axis.velocity(plant),
             IsNear((rest + (v0 - rest) * decay) * axis.along_B, kIntegrator));
  CHECK_THAT(axis.place(plant),
             IsNear((rest * t + (v0 - rest) * (1 - decay) * m / b) * axis.along_B, kIntegrator));
  if (axis.turns) CHECK(plant.p_B == Vec3{});
}

TEST_CASE("hand plant: the error of the integrator falls with the square of the step",
          "[device-io]") {
  // a firm hand rings: its spring is the hard part for the integrator
  const Axis axis = GENERATE(from_range(kAxes));
  SimulatedHandConfig config = bare_device(0.1, 0.5, 0, axis);
  config.hand_stiffness = 600;
  config.hand_rotational_stiffness = 0.6;
  const double x0 = axis.turns ? 0.3 : 0.01;
  const auto error = [&](int64_t chunk_ns) {
    HandPlant plant = axis.at(x0, 0);
    const Intention still = [](double) { return Intent{}; };
    for (int64_t t = 0; t < 200 * kMs; t += chunk_ns) advance(config, still, plant, {}, chunk_ns);
    const double decay = 0.5 / (2 * 0.1), w = std::sqrt(600 / 0.1 - decay * decay), t = 0.2;
    const double exact =
        x0 * std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
    return norm(axis.place(plant) - exact * axis.along_B);
  };
  // chunks below kPlantStepNs are one step each
  const double coarse = error(20'000), fine = error(10'000);
  CAPTURE(coarse, fine);
  CHECK(coarse < 1e-5 * x0);
  CHECK(coarse / fine == Approx(4).epsilon(0.05));
}

TEST_CASE("hand plant: the energy ledger closes to rounding with friction, hand and wall",
          "[device-io]") {
  SimulatedHandConfig config;
  config.coulomb_friction = GENERATE(0.0, 0.05, 0.5);
  config.hand_stiffness = GENERATE(100.0, 600.0);
  config.hand_damping = GENERATE(0.0, 12.0);
  CAPTURE(config.coulomb_friction, config.hand_stiffness, config.hand_damping);
  HandPlant plant = start_plant(config);
  plant.v_B = {0.1, -0.2, 0.05};
  const double before = mechanical_energy(config, plant);
  double lost = 0;
  for (int k = 0; k < 3000; ++k) {
    // a wall that the hand presses into, held over each period
    const double depth = std::max(0.0, 0.05 - norm(plant.p_B));
    advance(config, plant, {800 * depth * normalized(plant.p_B), {}}, kMs);
    const double now_lost = plant.energy.device_loss + plant.energy.hand_loss;
    REQUIRE(now_lost >= lost);
    lost = now_lost;
  }
  const double change = mechanical_energy(config, plant) - before;
  const HandEnergy& energy = plant.energy;
  CAPTURE(energy.device_work, energy.intention_work, energy.device_loss, energy.hand_loss, change);
  REQUIRE(energy.intention_work > 1e-3);
  // 150 000 steps of roundings of 1e-17 J
  constexpr double kLedgerJ = 1e-11;
  CHECK(std::fabs(energy.device_work + energy.intention_work - energy.device_loss -
                  energy.hand_loss - change) <= tol(kLedgerJ));
}

TEST_CASE("hand plant: friction stops a slide after m v squared over 2 f and then holds it",
          "[device-io]") {
  const Axis axis = GENERATE(from_range(kAxes));
  const SimulatedHandConfig config = bare_device(0.2, 0, 0.5, axis);
  HandPlant plant = axis.at(0, 0.3);
  advance(config, plant, {}, 300 * kMs);
  // stops within a step, in which it moves at most h·f/m·h
  CHECK_THAT(axis.place(plant), IsNear(0.2 * 0.09 / (2 * 0.5) * axis.along_B, 1e-8));
  CHECK(axis.velocity(plant) == Vec3{});
  CHECK(plant.energy.device_loss == Approx(axis.scale() * 0.2 * 0.09 / 2).epsilon(tol(1e-11)));
  const Vec3 stopped_B = axis.place(plant);
  const Vec3 across_B = any_perpendicular(axis.along_B);
  advance(config, plant, axis.push(axis.turns ? 0.499 * across_B : Vec3{0.499, -0.499, 0}),
          1000 * kMs);
  CHECK(axis.place(plant) == stopped_B);
  advance(config, plant, axis.push(0.501 * axis.along_B), 1000 * kMs);
  CHECK(dot(axis.along_B, axis.place(plant) - stopped_B) > 0);
}

TEST_CASE("hand plant: a hand settles on its intention displaced by force over stiffness",
          "[device-io]") {
  SimulatedHandConfig config;
  config.inertia = 1e-4;
  config.coulomb_friction = config.rotational_friction = 0;
  const Vec3 force_B{1, -2, 3}, torque_B{0.1, -0.2, 0.3}, place_B{0.1, 0.02, -0.03};
  // more than half a turn the other way round is the same orientation, by the shorter arc
  const Quat turned = from_rotation_vector({0, 0, 2 * std::numbers::pi - 0.4});
  const Intention intention = [&](double) { return Intent{place_B, {}, turned, {}}; };
  HandPlant plant = start_plant(config, intention);
  plant.q_B = {};
  advance(config, intention, plant, {force_B, torque_B}, 4000 * kMs);
  CHECK_THAT(plant.p_B - place_B, IsNear(force_B / config.hand_stiffness, 1e-9));
  CHECK_THAT(to_rotation_vector(plant.q_B * conjugate(turned)),
             IsNear(torque_B / config.hand_rotational_stiffness, 1e-9));
  CHECK(to_rotation_vector(plant.q_B).z > -0.4);
}

// exact limits from the Schur–Cohn criterion for the sampled, held wall; with everything of a row
// scaled by J/m the characteristic polynomial is the same
TEST_CASE("hand plant: the stability limit of a sampled wall is that of the table in 8.1",
          "[device-io]") {
  struct Row {
    double m, b, B;
    int64_t period_ns;
    int delay;
    double limit;
  };
  const Row row = GENERATE(Row{0.1, 0.8, 0, kMs, 0, 1602}, Row{0.1, 0.8, 0, kMs, 1, 534},
                           Row{0.1, 0.8, 0, kMs, 2, 321}, Row{0.1, 0.8, 2, kMs, 0, 5497},
                           Row{0.1, 0.8, 2, kMs, 1, 1830}, Row{1.0, 5, 0, kMs, 0, 10008},
                           Row{1.0, 5, 0, kMs, 1, 3338}, Row{0.1, 0.8, 0, 10 * kMs, 0, 162},
                           Row{0.1, 0.1, 5, kMs, 0, 9704}, Row{0.1, 0.1, 60, kMs, 0, 64757});
  const Axis axis = GENERATE(false, true) ? kAxes.back() : kAxes.front();
  CAPTURE(row.m, row.b, row.B, row.period_ns, row.delay, row.limit, axis.turns);
  // 1 % of K change the envelope by a thirtieth of its damping at least
  constexpr double kBand = 0.01;
  const int periods = row.period_ns > kMs ? 3000 : 5000;
  const auto growth_at = [&](double stiffness) {
    return growth({bare_device(row.m, row.b, 0, axis),
                   {stiffness, row.B, row.period_ns, row.delay},
                   -0.0005,
                   0,
                   axis},
                  periods);
  };
  CHECK(growth_at((1 - kBand) * row.limit) < 1);
  CHECK(growth_at((1 + kBand) * row.limit) > 1);
}

TEST_CASE("hand plant: inside the limit of Abbott and Okamura a quantised wall is passive",
          "[device-io]") {
  // K ≤ min(2b/T, 2f/Δ) (Abbott & Okamura 2005): damping and friction absorb the wall's energy
  const double b = 2, step = 40e-6;
  const double friction = GENERATE(0.02, 0.05, 0.2, 0.5);
  const double share = GENERATE(0.3, 0.95);
  const double v0 = GENERATE(0.02, 0.1, 0.4);
  SimulatedHandConfig device = bare_device(0.1, b);
  device.coulomb_friction = friction;
  const double stiffness = share * std::min(2 * b / 1e-3, 2 * friction / step);
  CAPTURE(friction, share, v0, stiffness);
  WallLoop loop(device, {stiffness, 0, kMs, 0, step}, 0, v0);
  for (int k = 0; k < 3000; ++k) {
    loop.step();
    REQUIRE(loop.plant.energy.device_work <= loop.plant.energy.device_loss + tol(kAlgebra));
  }
  // no limit cycle is left
  const Vec3 rest_B = loop.plant.p_B;
  for (int k = 0; k < 500; ++k) loop.step();
  CHECK_THAT(loop.plant.p_B, IsNear(rest_B, 1e-12));
}

TEST_CASE("hand plant: far outside the limit of Abbott and Okamura a quantised wall never rests",
          "[device-io]") {
  const double b = 2, step = 40e-6;
  SimulatedHandConfig device = bare_device(0.1, b);
  device.coulomb_friction = GENERATE(0.02, 0.05);
  const double stiffness = 4 * std::max(2 * b / 1e-3, 2 * device.coulomb_friction / step);
  WallLoop loop(device, {stiffness, 0, kMs, 0, step}, 0, 0.1);
  double largest = 0;
  for (int k = 0; k < 3000 && largest < 1; ++k) {
    loop.step();
    if (k > 100) largest = std::max(largest, std::fabs(loop.plant.p_B.x));
  }
  CHECK(largest > 10 * step);
}

// with displacements y of the held steps the spring leaks, Σ K y_k(y_{k+1} − y_k)
TEST_CASE("hand plant: a held spring leaks half K times the sum of squared displacements",
          "[device-io]") {
  SimulatedHandConfig device = bare_device(0.1, 0.8);
  device.coulomb_friction = GENERATE(0.0, 0.03);
  const double K = GENERATE(300.0, 1500.0, 2500.0);
  WallLoop loop(device, {K, 0, kMs}, -0.001, 0.2);
  const double start = loop.plant.p_B.x;
  double previous = start, squares = 0, paired = 0, wrongly_paired = 0;
  for (int k = 0; k < 400; ++k) {
    loop.step();
    const double y = loop.plant.p_B.x, dy = y - previous;
    squares += dy * dy;
    paired += K * previous * dy;   // the held force paired with the displacement of its step
    wrongly_paired += K * y * dy;  // the backward difference
    previous = y;
  }
  const double potential = K / 2 * (previous * previous - start * start);
  const double size = K * (squares + start * start);
  // work of the device = − work done on the spring: the energy that the hand receives
  CHECK(std::fabs(-loop.plant.energy.device_work - paired) <= tol(1e-12) * size);
  CHECK(std::fabs(paired - (potential - K / 2 * squares)) <= tol(1e-12) * size);
  CHECK(std::fabs(wrongly_paired - (potential + K / 2 * squares)) <= tol(1e-12) * size);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety/passivity.cpp against identities, and with a sampled wall hit by a mass.
#include "servo/safety/passivity.h"

#include <random>
#include <vector>

#include "servo/safety/safety.h"
#include "tests/support/near.h"

using haptic::PassivityInput;
using haptic::PassivityState;
using haptic::Vec3;

namespace {

constexpr double kDt = 1e-3;
constexpr int64_t kTickNs = 1'000'000;

PassivityInput moving(const Vec3& p, int64_t t_ns, const Vec3& surface, const Vec3& force,
                      double max_damping) {
  return {{p, {}}, t_ns, {surface, {}}, {force, {}}, max_damping, 0};
}

/// One tick of the port: the controller's output for a force at this position.
haptic::PassivityOutput pass(PassivityState& state, int64_t tick, const Vec3& p, const Vec3& force,
                             double max_damping, const Vec3& surface = {}) {
  const auto out =
      haptic::keep_passive(state, moving(p, tick * kTickNs, surface, force, max_damping), kDt);
  haptic::note_held(state, out.F_B, kDt);
  return out;
}

/// A mass with a damper on one axis against the wall force(x, v), sampled with a zero-order hold
/// and solved exactly between two samples.
struct Mass {
  double m = 0.1, b = 0.8, x = 0, v = 0;

  void advance(double force, double dt) {
    if (b == 0) {
      x += v * dt + 0.5 * force / m * dt * dt;
      v += force / m * dt;
      return;
    }
    const double steady = force / b, decay = std::exp(-b / m * dt);
    x += steady * dt + (v - steady) * m / b * (1 - decay);
    v = steady + (v - steady) * decay;
  }
};

struct Run {
  double amplitude = 0;  // peak to peak in the last half [m]
  double energy = 0;     // supplied by the hand: negative if the wall is active [J]
};

/// A mass dropped onto a wall of stiffness K under a constant push.
Run on_wall(double stiffness, double max_damping, bool controlled, double push = 0.5) {
  Mass mass;
  mass.v = -0.05;
  PassivityState state;
  Run run;
  double low = 1, high = -1;
  const int ticks = 3000;
  for (int k = 0; k < ticks; ++k) {
    Vec3 force{std::max(-stiffness * mass.x, 0.0), 0, 0};
    const Vec3 p{mass.x, 0, 0};
    if (controlled) force = pass(state, k, p, force, max_damping).F_B.f;
    const double before = mass.x;
    mass.advance(force.x - push, kDt);
    run.energy -= force.x * (mass.x - before);
    if (k > ticks / 2) low = std::min(low, mass.x), high = std::max(high, mass.x);
  }
  run.amplitude = high - low;
  return run;
}

}  // namespace

TEST_CASE("passivity: pairing trap: the leak of a sampled wall is seen with its sign",
          "[servo][trap]") {
  // Σ K y_k (y_{k+1} − y_k) = ½K(y_n² − y_0²) − ½K Σ Δy²
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> uniform(0.5e-3, 2e-3);
  const double K = 1000;
  PassivityState state;
  double y = 1e-3, squares = 0;
  const double y0 = y;
  for (int k = 0; k < 20; ++k) {
    // y is the depth; the wall pushes along +x
    const Vec3 p{-y, 0, 0}, force{K * y, 0, 0};
    pass(state, k, p, force, 0);
    const double next = uniform(rng);
    squares += (next - y) * (next - y);
    y = next;
  }
  pass(state, 20, {-y, 0, 0}, {K * y, 0, 0}, 0);
  const double stored = 0.5 * K * (y * y - y0 * y0);
  CHECK(state.energy == Approx(stored - 0.5 * K * squares).epsilon(1e-12));
  // the wrong pairing would show the wall absorbing as much as it gives
  CHECK(state.energy < stored);
}

TEST_CASE("passivity: a wall within the limit of Colgate and Schenkel is left alone", "[servo]") {
  // K < 2b/T = 1600 N/m
  Mass mass;
  mass.v = -0.1;
  PassivityState state;
  int damped = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p{mass.x, 0, 0}, force{std::max(-400 * mass.x, 0.0), 0, 0};
    damped += pass(state, k, p, force, 2).damped ? 1 : 0;
    mass.advance(force.x - 0.5, kDt);
  }
  CHECK(damped == 0);
}

TEST_CASE("passivity: a wall that is too stiff buzzes, and with the controller it does not",
          "[servo]") {
  // 2500 N/m, above the limit of 1600 N/m
  const Run loose = on_wall(2500, 0, false), kept = on_wall(2500, 0.8, true);
  CHECK(loose.energy < -5e-3);
  CHECK(loose.amplitude > 0.5e-3);
  CHECK(kept.amplitude < loose.amplitude / 4);
  CHECK(kept.energy > loose.energy / 3);
  // twice the stiffness that is stable alone
  CHECK(on_wall(3200, 2, true).amplitude < on_wall(3200, 0, false).amplitude / 5);
}

TEST_CASE("passivity: the damper stays within its bound and against the motion", "[servo]") {
  PassivityState state;
  pass(state, 0, {}, {5, 0, 0}, 0.1);
  // pushed along by 10 mm: 50 mJ were released in one tick
  const Vec3 step{0.01, 0, 0};
  const auto out = pass(state, 1, step, {5, 0, 0}, 0.1);
  CHECK(out.damped);
  CHECK(state.energy == Approx(-0.05));
  CHECK(out.F_B.f.x == Approx(5 - 0.1 * 0.01 / kDt));
}

TEST_CASE("passivity: a wall that is left pulls no more than it pushed", "[servo]") {
  PassivityState state;
  pass(state, 0, {}, {3, 0, 0}, 5);
  // at 10 m/s the damper alone would give 50 N
  CHECK(pass(state, 1, {0.01, 0, 0}, {}, 5).F_B.f.x == Approx(-2.9).margin(0.11));
  CHECK(pass(state, 2, {0.02, 0, 0}, {}, 0).F_B.f.x == 0);
}

TEST_CASE("passivity: after a gap the way is divided by the time that it took", "[servo]") {
  const double speed = 0.5;
  PassivityState state;
  state.energy = -20e-3;
  pass(state, 0, {}, {4, 0, 0}, 0);
  // stale samples change nothing
  for (int k = 1; k <= 4; ++k) {
    const auto held = haptic::keep_passive(state, moving({}, 0, {}, {4, 0, 0}, 2), kDt);
    CHECK_FALSE(held.damped);
    haptic::note_held(state, held.F_B, kDt);
  }
  const double before = state.energy;
  const auto out = pass(state, 5, {5 * kDt * speed, 0, 0}, {2.75, 0, 0}, 2);
  CHECK(state.energy == Approx(before - 4 * 5 * kDt * speed));
  CHECK(out.F_B.f.x == Approx(2.75 - 2 * speed));
}

TEST_CASE("passivity: a moving object may push, that work is its own", "[servo]") {
  PassivityState state;
  const Vec3 velocity{0.1, 0, 0};
  for (int k = 0; k <= 1000; ++k) {
    CHECK_FALSE(pass(state, k, k * kDt * velocity, {2, 0, 0}, 2, velocity).damped);
  }
  CHECK(std::fabs(state.energy) < 1e-12);
}

TEST_CASE("passivity: free space begins a new account, and a debt is bounded", "[servo]") {
  PassivityState state;
  pass(state, 0, {}, {10, 0, 0}, 0);
  pass(state, 1, {1, 0, 0}, {}, 0);
  CHECK(state.energy == -haptic::kPassivityDebt);
  // an energy debt decays slowly, a credit at once
  for (int k = 2; k < 502; ++k) pass(state, k, {1, 0, 0}, {}, 0);
  CHECK(state.energy == Approx(-haptic::kPassivityDebt * std::exp(-1)).epsilon(0.01));
  state.energy = 1;
  pass(state, 502, {1, 0, 0}, {}, 0);
  CHECK(state.energy == 0);
}

TEST_CASE("passivity: taps come back with no more energy than without the safety layer",
          "[servo]") {
  const double speed = GENERATE(0.1, 0.2, 0.5, 1.0), stiffness = GENERATE(500.0, 1000.0, 1500.0);
  const auto tap = [&](bool safe) {
    Mass mass{.m = 0.2, .b = 0, .x = 2e-3 * speed + 1e-5, .v = -speed};
    haptic::SafetyLimits limits{.max_force = 100, .max_torque = 1, .soft_start = 0};
    haptic::SafetyState state;
    state.gain = 1;
    for (int k = 0; k < 1000; ++k) {
      haptic::SafetyInput input;
      const bool inside = mass.x < 0;
      input.stiffness.translational = stiffness;
      input.F_B.f = {inside ? -stiffness * mass.x : 0, 0, 0};
      input.device.X_BH.p = {mass.x, 0, 0};
      input.device.V_BH.v = {mass.v, 0, 0};
      input.now_ns = input.device.t_ns = k * kTickNs;
      input.device.flags = haptic::kDeviceFresh | haptic::kDeviceHomed;
      const double force = safe ? make_safe(limits, state, input, kDt).F_B.f.x : input.F_B.f.x;
      mass.advance(force, kDt);
    }
    return 0.5 * mass.m * mass.v * mass.v;
  };
  const double with = tap(true), without = tap(false);
  CAPTURE(speed, stiffness, with, without);
  CHECK(with <= without * (1 + 1e-12));
  CHECK(with > 0);
}

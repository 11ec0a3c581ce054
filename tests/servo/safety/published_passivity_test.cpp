// SPDX-License-Identifier: GPL-3.0-or-later
// The passivity controller against published cases, for moving and for turning: a mass with a
// damper, pushed against a wall that is sampled and held. The plant is solved exactly here and
// shares nothing with the simulated hand.
#include <algorithm>
#include <cmath>
#include <vector>

#include "proto/math/units.h"
#include "servo/safety/safety.h"
#include "tests/support/near.h"

using namespace haptic;

namespace {

constexpr double kWallLever = 0.06;  // at which a turning wall is the moving one [m]
constexpr double kQuiet = 0.3e-3;    // three steps of the encoders: more is an oscillation [m]
const Vec3 kAxis = normalized(Vec3{1, 2, -2});

struct Case {
  double mass = 0;           // [kg]
  double damping = 0;        // of hand and device [N·s/m]
  double push = 0;           // of the hand into the wall [N]
  double speed = 0;          // at which it comes [m/s]
  double away = 0;           // from where: the phase of the contact to the samples [m]
  double stiffness = 0;      // of the wall [N/m]
  int hold = 1;              // samples for which the wall's force is held
  double max_damping = 0;    // of the controller; 0: there is none [N·s/m]
  double position_step = 0;  // 0: exact [m]
  double force_step = 0;     // 0: exact [N]
  double most_force = 1e9;   // of the device [N]
  double seconds = 1.5;
};

struct WallRun {
  int bounces = 0;        // times the wall was left for good, before the hand stays
  double amplitude = 0;   // peak to peak in the last third [m]
  double frequency = 0;   // there, by crossings of the mean [Hz]
  double energy = 0;      // that the hand put into the port, from the plant itself [J]
  double controller = 0;  // largest force of the controller [N]
};

double stepped(double value, double step) {
  return step > 0 ? step * std::floor(value / step + 0.5) : value;
}

/// Exact for a force that is constant over the time.
void advance(double mass, double damping, double force, double time, double& x, double& v) {
  const double steady = force / damping, decay = std::exp(-damping / mass * time);
  x += steady * time + (v - steady) * mass / damping * (1 - decay);
  v = steady + (v - steady) * decay;
}

/// The port of a wall: along x, or about an axis with everything scaled by the lever.
double through_port(PassivityState& state, const Case& wall, bool turning, int k, double x,
                    double force) {
  PassivityInput port;
  port.t_ns = k * int64_t{1'000'000};
  if (turning) {
    port.X_BH.q = from_rotation_vector(x / kWallLever * kAxis);
    port.F_B.t = force * kWallLever * kAxis;
    port.max_rotational_damping = wall.max_damping * kWallLever * kWallLever;
  } else {
    port.X_BH.p = {x, 0, 0};
    port.F_B.f = {force, 0, 0};
    port.max_damping = wall.max_damping;
  }
  Wrench F_B = keep_passive(state, port, kTick).F_B;
  const double kept = turning ? dot(F_B.t, kAxis) / kWallLever : F_B.f.x;
  const double given = std::clamp(kept, -wall.most_force, wall.most_force);
  F_B = given / (kept == 0 ? 1 : kept) * F_B;
  note_held(state, F_B, kTick);
  return given;
}

WallRun run(const Case& wall, bool turning) {
  double x = wall.away, v = -wall.speed, held = 0;
  PassivityState state;
  WallRun run;
  std::vector<double> last;
  bool inside = false;
  const int ticks = static_cast<int>(wall.seconds / kTick);
  for (int k = 0; k < ticks; ++k) {
    const double measured = stepped(x, wall.position_step);
    if (k % wall.hold == 0) {
      held = std::clamp(-wall.stiffness * measured, 0.0, wall.most_force);
      held = stepped(held, wall.force_step);
    }
    double force = held;
    if (wall.max_damping > 0) force = through_port(state, wall, turning, k, measured, held);
    run.controller = std::max(run.controller, std::fabs(force - held));
    const double before = x;
    advance(wall.mass, wall.damping, force - wall.push, kTick, x, v);
    run.energy -= force * (x - before);
    if (inside && x > 0) ++run.bounces;
    inside = x < 0;
    if (k >= ticks * 2 / 3) last.push_back(x);
  }
  const auto [low, high] = std::minmax_element(last.begin(), last.end());
  run.amplitude = *high - *low;
  double mean = 0;
  for (const double y : last) mean += y / static_cast<double>(last.size());
  int crossings = 0;
  for (size_t i = 1; i < last.size(); ++i) crossings += (last[i] > mean) != (last[i - 1] > mean);
  run.frequency = crossings / (2 * kTick * static_cast<double>(last.size()));
  return run;
}

Case without_controller(Case wall) {
  wall.max_damping = 0;
  return wall;
}

/// Excalibur of Hannaford & Ryu 2002: 1 kHz, 0.1 mm, 0.096 N, 200 N, contact at 0.2 m/s. Its moving
/// mass, the hand and the largest damping are not known here: 1.5 and 2.5 kg with 45 N·s/m, pushed
/// with 30 N, and 600 N·s/m are guesses. At 66.7 Hz the wall's force is held for 15 samples.
Case excalibur(double mass, double stiffness, int hold) {
  Case wall;
  wall.mass = mass;
  wall.damping = 45;
  wall.push = 30;
  wall.speed = 0.2;
  wall.stiffness = stiffness;
  wall.hold = hold;
  wall.max_damping = 600;
  wall.position_step = 0.1e-3;
  wall.force_step = 0.096;
  wall.most_force = 200;
  wall.seconds = 3;
  return wall;
}

/// The worst of fifteen phases, in which the contact falls between the samples.
struct Worst {
  WallRun loose{.bounces = 1000, .amplitude = 1}, kept;
};

Worst worst_of(Case wall, bool turning) {
  Worst worst;
  for (int i = 0; i < 15; ++i) {
    wall.away = 0.2e-3 * i;
    const WallRun loose = run(without_controller(wall), turning), kept = run(wall, turning);
    worst.loose.bounces = std::min(worst.loose.bounces, loose.bounces);
    worst.loose.amplitude = std::min(worst.loose.amplitude, loose.amplitude);
    worst.kept.bounces = std::max(worst.kept.bounces, kept.bounces);
    worst.kept.amplitude = std::max(worst.kept.amplitude, kept.amplitude);
    worst.kept.controller = std::max(worst.kept.controller, kept.controller);
  }
  return worst;
}

}  // namespace

TEST_CASE("passivity: Hannaford and Ryu's wall of 90 kN/m settles within six bounces",
          "[servo][published]") {
  const bool turning = GENERATE(false, true);
  const double mass = GENERATE(1.5, 2.5);
  const Worst worst = worst_of(excalibur(mass, 90e3, 1), turning);
  CAPTURE(turning, mass, worst.kept.controller);
  CHECK(worst.loose.amplitude > 0.3e-3);
  CHECK(worst.loose.bounces > 20);
  CHECK(worst.kept.bounces <= 6);
  CHECK(worst.kept.amplitude < kQuiet);
}

TEST_CASE("passivity: Hannaford and Ryu's wall of 30 kN/m at 66.7 Hz settles within one bounce",
          "[servo][published]") {
  const bool turning = GENERATE(false, true);
  const double mass = GENERATE(1.5, 2.5);
  const Worst worst = worst_of(excalibur(mass, 30e3, 15), turning);
  CAPTURE(turning, mass, worst.kept.controller);
  CHECK(worst.loose.amplitude > 10e-3);
  CHECK(worst.kept.bounces <= 1);
  CHECK(worst.kept.amplitude < kQuiet);
}

TEST_CASE("passivity: the limit cycle of a wall of 2500 N/m, with published figures",
          "[servo][published]") {
  // b = 0.8 N·s/m, 1 ms: 34 Hz, 1.66 mm peak to peak, −17.6 mJ in 1.5 s. Mass and push are not
  // stated; 30 g and 0.67 N are the ones that give all three figures.
  const bool turning = GENERATE(false, true);
  Case wall;
  wall.mass = 0.03;
  wall.damping = 0.8;
  wall.push = 0.67;
  wall.stiffness = 2500;
  wall.max_damping = 0.8;
  const WallRun loose = run(without_controller(wall), turning), kept = run(wall, turning);
  CAPTURE(turning, kept.amplitude, kept.energy, kept.controller);
  CHECK(loose.frequency == Approx(34).margin(1.5));
  CHECK(loose.amplitude == Approx(1.66e-3).epsilon(0.02));
  CHECK(loose.energy == Approx(-17.6e-3).epsilon(0.05));
  // with a damper of at most 0.8 N·s/m: 0.08 mm, −1.8 mJ; this one does not do worse
  CHECK(kept.amplitude < 0.08e-3);
  CHECK(kept.energy > -1.8e-3);
}

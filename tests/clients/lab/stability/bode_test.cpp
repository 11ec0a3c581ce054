// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/bode.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace haptic;

namespace {

using Complex = std::complex<double>;
constexpr Complex kJ{0, 1};

/// Spring and filtered backward difference, sampled, late and held: what the wall must be.
Complex held_wall(const ProbeSetting& setting, double frequency) {
  const double T = 1 / setting.rate, omega = 2 * std::numbers::pi * frequency;
  const Complex later = std::exp(-kJ * omega * T);
  const double pole = 1 / (2 * std::numbers::pi * setting.hand.velocity_cutoff);
  const double share = T / (T + pole);
  const Complex filter = share / (1.0 - (1 - share) * later);
  const Complex by_place = setting.stiffness + setting.damping * filter * (1.0 - later) / T;
  // the hold: (1 − exp(−jωT))/(jωT)
  const Complex hold = (1.0 - later) / (kJ * omega * T);
  return by_place * std::pow(later, setting.delay) * hold / (kJ * omega);
}

ProbeSetting setting_of(bool turning, double stiffness, double damping) {
  ProbeSetting setting;
  setting.turning = turning;
  setting.hand.inertia = 1e-4;
  setting.hand.encoder_step = setting.hand.angle_step = 0;
  setting.stiffness = stiffness;
  setting.damping = damping;
  return setting;
}

}  // namespace

TEST_CASE("bode: the closed form of a spring and a damper that are sampled and held", "[lab]") {
  const bool turning = GENERATE(false, true);
  const ProbeScene scene(turning);
  ProbeSetting setting = setting_of(turning, turning ? 1 : 800, GENERATE(0.0, 0.4));
  if (turning) setting.damping *= 1.25e-3;
  setting.delay = GENERATE(0u, 1u, 3u);
  setting.rate = GENERATE(1000.0, 4000.0);
  const Bode bode = measure_bode(scene, setting, 1);
  REQUIRE(bode.points.size() > 15);
  for (const BodePoint& point : bode.points) {
    const Complex exact = held_wall(setting, point.frequency);
    CAPTURE(turning, point.frequency, point.rendered, exact);
    CHECK(std::abs(point.rendered - exact) < (turning ? 1e-3 : 1e-6) * std::abs(exact));
    const Complex meant =
        setting.damping + setting.stiffness / (2 * std::numbers::pi * point.frequency * kJ);
    CHECK(std::abs(point.intended - meant) < 1e-12 * std::abs(meant));
  }
  CHECK(bode.points.front().frequency == Approx(setting.rate / 1000));
  CHECK(bode.points.back().frequency == Approx(0.449 * setting.rate));
  if (!turning) CHECK(bode.distortion < 1e-9);
}

TEST_CASE("bode: an encoder's steps are averaged out", "[lab]") {
  const ProbeScene scene(false);
  ProbeSetting setting = setting_of(false, 800, 0);
  setting.hand.encoder_step = 20e-6;
  const Bode bode = measure_bode(scene, setting, 4);
  for (const BodePoint& point : bode.points) {
    if (point.frequency > 100) continue;
    const Complex exact = held_wall(setting, point.frequency);
    CAPTURE(point.frequency, point.rendered, exact);
    CHECK(std::abs(point.rendered - exact) < 0.05 * std::abs(exact));
  }
}

TEST_CASE("bode: a wall that lets go is not linear", "[lab]") {
  const ProbeScene scene(false);
  const ProbeSetting setting = setting_of(false, 800, 0), clamped = setting_of(false, 800, 100);
  CHECK(measure_bode(scene, setting, 1).distortion < 1e-9);
  CHECK(measure_bode(scene, clamped, 1).distortion > 0.01);
}

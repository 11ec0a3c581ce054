// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/zwidth.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kNoFilter = 1e9;  // of the velocity [Hz]: the backward difference itself

/// Mass and damper in nobody's hand, without friction, encoder or filter; moving and, with
/// everything scaled by kScale, turning.
constexpr double kScale = 1e-3;  // [m²]
ProbeSetting bare(double mass, double damping, bool turning = false) {
  ProbeSetting out;
  out.turning = turning;
  SimulatedHandConfig& hand = out.hand;
  hand.mass = mass;
  hand.damping = damping;
  hand.inertia = kScale * mass;
  hand.rotational_damping = kScale * damping;
  hand.coulomb_friction = hand.rotational_friction = hand.encoder_step = hand.angle_step = 0;
  hand.hand_mass = hand.hand_damping = hand.hand_stiffness = 0;
  hand.hand_inertia = hand.hand_rotational_damping = hand.hand_rotational_stiffness = 0;
  hand.velocity_cutoff = kNoFilter;
  return out;
}

const ProbeScene& scene(bool turning) {
  static const ProbeScene moving(false), turned(true);
  return turning ? turned : moving;
}

/// A row of the exact table: Schur–Cohn on the sampled, held wall, computed elsewhere.
struct Row {
  double m, b, B, T;
  uint32_t delay;
  double limit;
};

bool is_stable(const Row& row, bool turning, double share) {
  const double scale = turning ? kScale : 1;
  ProbeSetting setting = bare(row.m, row.b, turning);
  setting.rate = 1 / row.T;
  setting.delay = row.delay;
  setting.damping = scale * row.B;
  setting.stiffness = share * scale * row.limit;
  return dies_out(ring(scene(turning), setting));
}

}  // namespace

TEST_CASE("zwidth: through the servo's own step the limits are those of the exact table", "[lab]") {
  const Row row = GENERATE(Row{0.1, 0.8, 0, 1e-3, 0, 1602}, Row{0.1, 0.8, 0, 1e-3, 1, 534},
                           Row{0.1, 0.8, 0, 1e-3, 2, 321}, Row{0.1, 0.8, 2, 1e-3, 0, 5497},
                           Row{0.1, 0.8, 2, 1e-3, 1, 1830}, Row{1.0, 5, 0, 1e-3, 0, 10008},
                           Row{1.0, 5, 0, 1e-3, 1, 3338}, Row{0.1, 0.8, 0, 1e-2, 0, 162},
                           Row{0.1, 0.1, 5, 1e-3, 0, 9704}, Row{0.1, 0.1, 60, 1e-3, 0, 64757});
  // turning has the same table, scaled by the inertia
  const bool turning = GENERATE(false, true);
  CAPTURE(row.m, row.b, row.B, row.T, row.delay, row.limit, turning);
  constexpr double kBand = 0.03;
  CHECK(is_stable(row, turning, 1 - kBand));
  CHECK_FALSE(is_stable(row, turning, 1 + kBand));
}

TEST_CASE("zwidth: one sample of delay divides the largest stiffness by three, two by five",
          "[lab]") {
  ProbeSetting setting = bare(0.1, 0.8);
  const LargestStiffness at_once = largest_stiffness(scene(false), setting);
  CHECK(at_once.stiffness == Approx(1602).epsilon(0.03));
  CHECK_FALSE(at_once.is_at_the_end);
  for (const uint32_t delay : {1u, 2u}) {
    setting.delay = delay;
    const double late = largest_stiffness(scene(false), setting).stiffness;
    CHECK(at_once.stiffness / late == Approx(1 + 2 * delay).epsilon(0.03));
  }
}

TEST_CASE("zwidth: stiffness rises with damping, then falls", "[lab]") {
  ProbeSetting setting = bare(0.1, 0.8);
  const auto largest_at = [&](double damping) {
    setting.damping = damping;
    return largest_stiffness(scene(false), setting).stiffness;
  };
  const double none = largest_at(0), some = largest_at(60), much = largest_at(180);
  CAPTURE(none, some, much);
  CHECK(some > 10 * none);
  CHECK(much < 0.9 * some);
}

TEST_CASE("zwidth: inside the bound of Gil nothing rings", "[lab]") {
  Random random(11);
  for (int i = 0; i < static_cast<int>(trials(20)); ++i) {
    // the bound holds for small b T/m and B T/m; of the latter it knows nothing, so the share of
    // it that is kept away from is as large
    ProbeSetting setting = bare(random.uniform(0.05, 1), 1);
    const double most = 0.02 * setting.hand.mass * setting.rate;
    setting.hand.damping = random.uniform(0.2, 1) * most;
    setting.delay = static_cast<uint32_t>(random.uniform(0, 4));
    const bool is_damped = i % 2 == 0;
    if (is_damped) setting.damping = random.uniform(0, 0.5) * most;
    const double share = random.uniform(0.5, is_damped ? 0.93 : 0.99);
    setting.stiffness = share * gil_limit(setting);
    CAPTURE(setting.hand.mass, setting.hand.damping, setting.damping, setting.delay, share);
    REQUIRE(dies_out(ring(scene(false), setting)));
  }
}

TEST_CASE("zwidth: inside the bound of Abbott and Okamura nothing rings, far outside all does",
          "[lab]") {
  Random random(12);
  for (int i = 0; i < static_cast<int>(trials(20)); ++i) {
    ProbeSetting setting = bare(random.uniform(0.05, 0.5), random.uniform(0.3, 3));
    setting.hand.encoder_step = random.uniform(5e-6, 60e-6);
    setting.hand.coulomb_friction = random.uniform(0.02, 0.3);
    const double share = random.uniform(0.3, 0.97);
    setting.stiffness = share * abbott_okamura_limit(setting);
    CAPTURE(setting.hand.mass, setting.hand.damping, setting.hand.encoder_step,
            setting.hand.coulomb_friction, setting.stiffness);
    REQUIRE(dies_out(ring(scene(false), setting)));
    // beyond what damping and friction can take together
    const double by_friction = 2 * setting.hand.coulomb_friction / setting.hand.encoder_step;
    setting.stiffness = 4 * std::max(2 * setting.hand.damping * setting.rate, by_friction);
    CHECK_FALSE(dies_out(ring(scene(false), setting)));
  }
}

TEST_CASE("zwidth: what is sustained and what dies out", "[lab]") {
  // pressed 1 mm deep, an encoder of 20 µm
  CHECK(dies_out({1e-3, 400e-6, 59e-6, 20e-6}));
  CHECK_FALSE(dies_out({1e-3, 61e-6, 61e-6, 20e-6}));
  CHECK(dies_out({1e-3, 400e-6, 300e-6, 20e-6}));
  CHECK_FALSE(dies_out({1e-3, 400e-6, 390e-6, 20e-6}));
  // two steps, but a fifth of the press
  CHECK_FALSE(dies_out({2e-4, 40e-6, 40e-6, 20e-6}));
  CHECK(dies_out({2e-4, 400e-6, 19e-6, 20e-6}));
  // without one
  CHECK(dies_out({1e-3, 400e-6, 390e-6, 0}));
  CHECK_FALSE(dies_out({1e-3, 400e-6, 401e-6, 0}));
  CHECK(dies_out({1e-3, 1e-9, 2e-9, 0}));
  // it hops, however it was before
  CHECK_FALSE(dies_out({1e-3, 1e-2, 2e-3, 0}));
  CHECK_FALSE(dies_out({1e-5, 0, 2e-5, 20e-6}));
  CHECK_FALSE(dies_out({1e-3, 1, std::nan(""), 0}));
}

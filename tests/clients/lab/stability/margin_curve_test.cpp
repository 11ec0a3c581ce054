// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/margin_curve.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "clients/lab/stability/zwidth.h"
#include "tests/support/meshes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// The criterion by complex arithmetic, as it is written in the paper.
double by_definition(const CoupledAxis& axis, double frequency) {
  using Response = std::complex<double>;
  const double T = axis.period;
  const Response later = std::exp(Response(0, -2 * std::numbers::pi * frequency * T));
  const Response hold = 0.5 * (1.0 + later);
  const Response device = axis.damping + axis.mass * (1.0 - later) / T;
  const Response coupling = axis.coupling_damping + axis.stiffness * T / (1.0 - later);
  return std::cos(std::arg(hold)) + 2 * device.real() * (1.0 / coupling).real() / std::abs(hold) -
         1;
}

CoupledAxis any_axis(Random& random) {
  CoupledAxis axis;
  axis.mass = random.uniform(0.02, 0.5);
  axis.damping = random.uniform(0.3, 3);
  axis.coupling_damping = random.uniform(0, 0.5) * axis.damping;
  axis.stiffness = random.uniform(50, 5000);
  return axis;
}

}  // namespace

TEST_CASE("margin curve: the criterion as the paper writes it, over frequency", "[lab]") {
  Random random(21);
  for (int i = 0; i < 20; ++i) {
    const CoupledAxis axis = any_axis(random);
    for (const MarginPoint& point : margin_curve(axis)) {
      const double exact = by_definition(axis, point.frequency);
      REQUIRE(point.margin == Approx(exact).epsilon(1e-6).margin(1e-6));
    }
  }
}

TEST_CASE("margin curve: its least is the margin, and it goes up to half the rate", "[lab]") {
  Random random(22);
  for (int i = 0; i < 20; ++i) {
    const CoupledAxis axis = any_axis(random);
    const auto curve = margin_curve(axis);
    double least = curve[0].margin;
    for (const MarginPoint& point : curve) least = std::min(least, point.margin);
    CHECK(least >= two_port_margin(axis));
    CHECK(least == Approx(two_port_margin(axis)).margin(0.02));
    CHECK(curve.back().frequency == Approx(0.5 / axis.period).epsilon(0.01));
    CHECK(std::is_sorted(curve.begin(), curve.end(),
                         [](const auto& a, const auto& b) { return a.frequency < b.frequency; }));
  }
}

TEST_CASE("margin curve: up to the largest stiffness there is a margin, and not beyond", "[lab]") {
  Random random(23);
  for (int i = 0; i < 20; ++i) {
    CoupledAxis axis = any_axis(random);
    const double most = largest_with_margin(axis);
    REQUIRE(most > 0);
    axis.stiffness = most;
    CHECK(two_port_margin(axis) >= 0);
    CHECK(most < passive_stiffness(axis));
    axis.stiffness = 1.01 * most;
    CHECK((two_port_margin(axis) < 0 || axis.stiffness >= passive_stiffness(axis)));
  }
  CHECK(largest_with_margin({0.1, 0.2, 100, 0.3, 1e-3}) == 0);
}

TEST_CASE("margin curve: what has a margin is stable in the servo, in every hand", "[lab]") {
  const ProbeScene scene(false);
  Random random(24);
  for (int i = 0; i < static_cast<int>(trials(20)); ++i) {
    const CoupledAxis axis = any_axis(random);
    ProbeSetting setting;
    setting.hand.mass = axis.mass;
    setting.hand.damping = axis.damping;
    setting.hand.coulomb_friction = setting.hand.encoder_step = 0;
    setting.hand.velocity_cutoff = 1e9;
    // a passive hand: a mass, a damper and a spring, or none of them
    const bool is_held = i % 3 > 0;
    setting.hand.hand_mass = is_held ? random.uniform(0, 2) : 0;
    setting.hand.hand_damping = is_held ? random.uniform(0, 10) : 0;
    setting.hand.hand_stiffness = is_held ? random.uniform(0, 1000) : 0;
    setting.damping = axis.coupling_damping;
    setting.stiffness = random.uniform(0.3, 1) * largest_with_margin(axis);
    CAPTURE(axis.mass, axis.damping, setting.damping, setting.stiffness, is_held);
    REQUIRE(dies_out(ring(scene, setting)));
  }
}

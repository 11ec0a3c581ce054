// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/solve/coupled_body.cpp and the ramp of servo/tick.cpp.
#include "servo/solve/coupled_body.h"
#include "servo/tick.h"

#include "tests/support/near.h"

using haptic::Coupling;
using haptic::coupling_force;
using haptic::CouplingRamp;
using haptic::Vec3;
using haptic::test::IsNear;

TEST_CASE("coupling: zero at coincident points", "[servo]") {
  CHECK(coupling_force({800, 5}, {{1, 2, 3}, {1, 2, 3}, {1, 0, 0}, {}}) == Vec3{});
}

TEST_CASE("coupling: the spring pulls the tool to the proxy", "[servo]") {
  const Vec3 f = coupling_force({1000, 0}, {{0, 0, -2e-3}, {0, 0, 0}, {}, {}});
  CHECK_THAT(f, IsNear({0, 0, 2}, 1e-15));
}

TEST_CASE("coupling: force is minus the gradient of the spring energy", "[servo]") {
  const double k = 730;
  const Vec3 proxy{0.01, -0.02, 0.005}, tool{0.012, -0.017, 0.001};
  auto energy = [&](const Vec3& x) { return 0.5 * k * norm_squared(proxy - x); };
  const double h = 1e-6;
  Vec3 gradient;
  for (int i = 0; i < 3; ++i) {
    Vec3 step;
    step[i] = h;
    gradient[i] = (energy(tool + step) - energy(tool - step)) / (2 * h);
  }
  CHECK_THAT(coupling_force({k, 0}, {tool, proxy, {}, {}}), IsNear(-gradient, 1e-7));
}

TEST_CASE("coupling: damping acts along the spring, brakes the entry and never pulls", "[servo]") {
  const Coupling c{1000, 10};
  const Vec3 tool{0, 0, -1e-3}, proxy{};
  // entering at 0.1 m/s: more force; leaving: less; sliding: no drag
  CHECK_THAT(coupling_force(c, {tool, proxy, {0, 0, -0.1}, {}}), IsNear({0, 0, 2}, 1e-12));
  CHECK_THAT(coupling_force(c, {tool, proxy, {0, 0, 0.05}, {}}), IsNear({0, 0, 0.5}, 1e-12));
  CHECK_THAT(coupling_force(c, {tool, proxy, {0, 0, 1}, {}}), IsNear({0, 0, 0}, 1e-12));
  CHECK_THAT(coupling_force(c, {tool, proxy, {0.3, 0, 0}, {}}), IsNear({0, 0, 1}, 1e-12));
  // a surface that moves along does not brake
  CHECK_THAT(coupling_force(c, {tool, proxy, {0, 0, -0.1}, {0, 0, -0.1}}),
             IsNear({0, 0, 1}, 1e-12));
}

TEST_CASE("coupling: parameters ramp over 200 ms, up and down, however far", "[servo]") {
  const auto [from, to] = GENERATE(
      table<double, double>({{1000.0, 500.0}, {100000.0, 500.0}, {500.0, 2000.0}, {2000.0, 0.0}}));
  CouplingRamp ramp{{from, 1}, {from, 1}, 0};
  double before = from, largest_step = 0;
  for (int i = 1; i <= 200; ++i) {
    const Coupling now = ramp_coupling(ramp, {to, 2}, 1e-3);
    largest_step = std::max(largest_step, std::fabs(now.translational_stiffness - before));
    before = now.translational_stiffness;
    CHECK(now.translational_stiffness == Approx(from + i / 200.0 * (to - from)).margin(1e-6));
  }
  CHECK(ramp_coupling(ramp, {to, 2}, 1e-3) == Coupling{to, 2});
  CHECK(largest_step <= std::fabs(to - from) / 200 * (1 + 1e-9));
}

TEST_CASE("coupling: a new wish in mid-ramp goes on from where the parameters are", "[servo]") {
  CouplingRamp ramp{{1000, 0}, {1000, 0}, 0};
  Coupling now;
  for (int i = 0; i < 100; ++i) now = ramp_coupling(ramp, {500, 0}, 1e-3);
  CHECK(now.translational_stiffness == Approx(750));
  CHECK(ramp_coupling(ramp, {1750, 0}, 1e-3).translational_stiffness == Approx(755));
}

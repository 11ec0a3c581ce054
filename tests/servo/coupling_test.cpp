// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/coupling.cpp.
#include "servo/coupling.h"

#include "tests/support/near.h"

using haptic::Coupling;
using haptic::coupling_force;
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
  // a surface that comes along brakes nothing
  CHECK_THAT(coupling_force(c, {tool, proxy, {0, 0, -0.1}, {0, 0, -0.1}}),
             IsNear({0, 0, 1}, 1e-12));
}

TEST_CASE("coupling: parameters ramp over 200 ms", "[servo]") {
  Coupling now{1000, 0};
  const Coupling span{1000, 0};
  double largest_step = 0;
  for (int i = 0; i < 250; ++i) {
    const double before = now.translational_stiffness;
    ramp_coupling(now, {500, 0}, span, 1e-3);
    largest_step = std::max(largest_step, std::fabs(now.translational_stiffness - before));
  }
  CHECK(now.translational_stiffness == 500);
  CHECK(largest_step <= 5.0 + 1e-9);
}

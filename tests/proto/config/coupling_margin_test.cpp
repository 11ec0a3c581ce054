// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/config/coupling_margin.h"

#include <cmath>

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// Swings of a device of mass m and damping b, stepped exactly through the hold, coupled to a proxy
/// that is fixed or a free mass integrated implicitly. Returns last energy over first.
double swing(const CoupledAxis& axis, double proxy_mass) {
  const double T = axis.period, m = axis.mass, b = axis.damping;
  const double e = std::exp(-b / m * T);
  double x = 1e-3, v = 0, last_x = x, x_p = 0, v_p = 0;
  double first = 0, last = 0;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) {
    const double measured = (x - last_x) / T;
    last_x = x;
    if (proxy_mass > 0) {
      // implicit Euler on the coupling: passive
      const double k = axis.stiffness, c = axis.coupling_damping;
      v_p = (proxy_mass * v_p + T * (k * (x - x_p) + c * measured)) /
            (proxy_mass + T * c + T * T * k);
      x_p += T * v_p;
    }
    const double force = axis.stiffness * (x_p - x) + axis.coupling_damping * (v_p - measured);
    const double end_speed = v * e + force / b * (1 - e);
    x += m / b * (1 - e) * v + force / b * (T - m / b * (1 - e));
    v = end_speed;
    const double energy = 0.5 * m * v * v + 0.5 * axis.stiffness * (x - x_p) * (x - x_p) +
                          0.5 * proxy_mass * v_p * v_p;
    if (i < steps / 10) first = std::max(first, energy);
    if (i >= steps - steps / 10) last = std::max(last, energy);
  }
  return last / first;
}

}  // namespace

TEST_CASE("coupling margin: the rule of thumb", "[proto]") {
  CHECK(passive_stiffness({0.1, 0.8, 0, 0.2, 1e-3}) == Approx(1200));
  CHECK(passive_stiffness({0.1, 0.2, 0, 0.3, 1e-3}) == 0);
}

TEST_CASE("coupling margin: more stiffness has less margin, more damping of the device more",
          "[proto]") {
  const CoupledAxis axis{0.1, 0.8, 400, 0.2, 1e-3};
  CoupledAxis stiffer = axis, damped = axis, slower = axis;
  stiffer.stiffness = 4000;
  damped.damping = 2;
  slower.period = 4e-3;
  CHECK(two_port_margin(stiffer) < two_port_margin(axis));
  CHECK(two_port_margin(damped) >= two_port_margin(axis));
  CHECK(two_port_margin(slower) < two_port_margin(axis));
}

TEST_CASE("coupling margin: what has a margin is stable, held fast and free", "[proto][trap]") {
  Random random(5);
  int with_both = 0, without = 0, alone_is_not_enough = 0;
  // 200 settings with a margin, none of them unstable
  const int wanted = static_cast<int>(trials(200));
  while (with_both < wanted) {
    CoupledAxis axis;
    axis.mass = random.uniform(0.02, 0.5);
    axis.damping = random.uniform(0.05, 3);
    axis.coupling_damping = random.uniform(0, 1);
    axis.stiffness = std::pow(10.0, random.uniform(1.5, 4.5));
    const double free_mass = std::pow(10.0, random.uniform(-3, 0));
    const bool unstable = swing(axis, 0) > 1 || swing(axis, free_mass) > 1 + 1e-9;
    CAPTURE(axis.mass, axis.damping, axis.stiffness, axis.coupling_damping, free_mass);
    if (two_port_margin(axis) < 0) {
      without += unstable;
    } else if (axis.stiffness < passive_stiffness(axis)) {
      ++with_both;
      REQUIRE_FALSE(unstable);
    } else {
      alone_is_not_enough += unstable;
    }
  }
  if (kSlowdown > 1) return;
  CHECK(without > 20);
  CHECK(alone_is_not_enough > 0);
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/safety/passivity.cpp with torque: one energy, and who pays.
#include <random>

#include "servo/safety/passivity.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kDt = 1e-3;
constexpr int64_t kTickNs = 1'000'000;

/// A port that was held with F from rest and has then moved and turned.
struct Port {
  PassivityState state;
  PassivityInput input;
  int64_t tick = 0;

  explicit Port(double max_damping = 2, double max_rotational_damping = 0.02) {
    input.max_damping = max_damping;
    input.max_rotational_damping = max_rotational_damping;
  }
  PassivityOutput hold(const Wrench& F_B) {
    input.F_B = F_B;
    input.t_ns = tick++ * kTickNs;
    const PassivityOutput out = keep_passive(state, input, kDt);
    note_held(state, out.F_B, kDt);
    return out;
  }
  void move(const Vec3& step_B, const Vec3& turn_B) {
    input.X_BH.p += step_B;
    input.X_BH.q = from_rotation_vector(turn_B) * input.X_BH.q;
  }
};

}  // namespace

TEST_CASE("passivity: the energy of six dimensions is the sum of what was held times what moved",
          "[servo][property]") {
  // the sum is made of the steps themselves, in extended precision; the port sees poses only
  std::mt19937_64 rng(20);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&](double most) { return most * Vec3{unit(rng), unit(rng), unit(rng)}; };
  Port port;
  port.state.energy = 5;
  port.state.turning = 2;
  port.input.surface_B = {any(0.1), any(1)};
  const Twist surface = port.input.surface_B;
  long double moving = 0, turning = 0;
  Wrench held;
  for (int k = 0; k < 2000; ++k) {
    if (k > 0) {
      const Vec3 step = any(2e-3), turn = any(20e-3);
      port.move(step, turn);
      for (int i = 0; i < 3; ++i) {
        const auto of = [i](const Vec3& a) { return i == 0 ? a.x : i == 1 ? a.y : a.z; };
        moving += static_cast<long double>(of(held.f)) * (of(step) - kDt * of(surface.v));
        turning += static_cast<long double>(of(held.t)) * (of(turn) - kDt * of(surface.w));
      }
    }
    held = port.hold({any(5), any(0.3)}).F_B;
    REQUIRE(port.state.energy - 5 == Approx(-static_cast<double>(moving + turning)).margin(1e-12));
    REQUIRE(port.state.turning - 2 == Approx(-static_cast<double>(turning)).margin(1e-12));
  }
  CHECK(std::fabs(static_cast<double>(turning)) > 1e-3);
}

TEST_CASE("passivity: a deficit is paid where it arose", "[servo]") {
  Port port;
  const Wrench F{{3, 0, 0}, {0, 0, 0.2}};
  port.hold(F);
  SECTION("by the torque, where the hand was turned along and pressed the wall in") {
    port.move({-1e-4, 0, 0}, {0, 0, 0.05});
    const PassivityOutput out = port.hold(F);
    CHECK(port.state.energy == Approx(3e-4 - 0.01));
    CHECK(out.damped);
    CHECK(out.F_B.f == F.f);
    CHECK(out.F_B.t.z < F.t.z);
    CHECK(out.F_B.t.x == 0);
  }
  SECTION("by the force, where it was pushed along and turned the part in") {
    port.move({4e-3, 0, 0}, {0, 0, -0.001});
    const PassivityOutput out = port.hold(F);
    CHECK(out.damped);
    CHECK(out.F_B.f.x < F.f.x);
    CHECK(out.F_B.t == F.t);
  }
  SECTION("by both in proportion, each of which covers its part within a tick") {
    Port gentle(1e3, 10);
    gentle.hold(F);
    gentle.move({0.1e-3, 0, 0}, {0, 0, 3e-3});
    const PassivityOutput out = gentle.hold(F);
    // after the tick, at the same velocity: 2 · 0.3 mJ and 2 · 0.6 mJ are missing
    const double deficit = 1.8e-3 - kPassivitySlack;
    CHECK((F.f.x - out.F_B.f.x) * 0.1e-3 == Approx(deficit / 3));
    CHECK((F.t.z - out.F_B.t.z) * 3e-3 == Approx(deficit * 2 / 3));
  }
  SECTION("by nobody, where both together are passive") {
    port.move({-4e-3, 0, 0}, {0, 0, 0.05});
    CHECK(port.state.turning == 0);
    CHECK_FALSE(port.hold(F).damped);
    CHECK(port.state.turning == Approx(-0.01));
  }
}

TEST_CASE("passivity: the damper of turning stays within its bound and against the turn",
          "[servo]") {
  Port port(0, 0.005);
  port.hold({{}, {0.3, 0, 0}});
  port.move({}, {0.03, 0.5, 0});
  const PassivityOutput out = port.hold({{}, {0.3, 0, 0}});
  CHECK(out.damped);
  // along the torque only: a smooth part stays smooth
  CHECK_THAT(out.F_B.t, IsNear({0.3 - 0.005 * 0.03 / kDt, 0, 0}, 1e-12));
  // and where it has let go it pulls no more than it pushed
  Port strong(0, 5);
  strong.hold({{}, {0.3, 0, 0}});
  strong.move({}, {0.1, 0, 0});
  CHECK(norm(strong.hold({}).F_B.t) <= 0.3);
}

TEST_CASE("passivity: an object that turns may turn the hand, that work is its own", "[servo]") {
  Port port;
  port.input.surface_B = {{}, {0, 0, 3}};
  for (int k = 0; k <= 1000; ++k) {
    CHECK_FALSE(port.hold({{}, {0, 0, 0.1}}).damped);
    port.move({}, {0, 0, 3 * kDt});
  }
  CHECK(std::fabs(port.state.energy) < 1e-12);
}

TEST_CASE("passivity: a debt of both is bounded, and forgotten together", "[servo]") {
  Port port(0, 0);
  port.hold({{10, 0, 0}, {0, 0, 1}});
  port.move({0.03, 0, 0}, {0, 0, 0.1});
  port.hold({});
  // 300 mJ and 100 mJ, of which 50 are left
  CHECK(port.state.energy == -kPassivityDebt);
  CHECK(port.state.turning == Approx(-kPassivityDebt / 4));
  for (int k = 0; k < 500; ++k) port.hold({});
  CHECK(port.state.energy == Approx(-kPassivityDebt * std::exp(-1)).epsilon(0.01));
  CHECK(port.state.turning == Approx(port.state.energy / 4));
  // a surplus of one that has covered the other is gone with it
  port.state.energy = 1e-3;
  port.state.turning = -2e-3;
  port.hold({});
  CHECK(port.state.energy == 0);
  CHECK(port.state.turning == 0);
}

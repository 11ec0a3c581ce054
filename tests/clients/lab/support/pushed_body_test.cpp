// SPDX-License-Identifier: GPL-3.0-or-later
// The world pushes back: bodies that a hand pushes, in closed loop, against an integration of the
// same equations at 20 µs.
#include <catch2/catch.hpp>

#include "tests/clients/lab/support/pushed_body.h"

using namespace haptic;
using namespace haptic::test;

namespace {

HandModel pushing_hand() {
  HandModel hand;
  hand.intent = rise(0, 0.06, 0.5);
  return hand;
}

/// A hand that flies against the box and touches it once.
HandModel flying_hand() {
  HandModel hand;
  hand.mass = 0.15;
  hand.damping = hand.stiffness = 0;
  hand.v = 0.3;
  return hand;
}

double kinetic(double m, double v) {
  return 0.5 * m * v * v;
}

}  // namespace

TEST_CASE("pushed body: a free body pushes back as one integrated at 20 µs does", "[pushed]") {
  constexpr double kStiffness = 800;
  constexpr int kTicks = 1'000;
  const double mass = GENERATE(0.005, 0.02, 0.2, 2.0);
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(mass, latency);
  Pushed pushed(PushedSession(mass, kStiffness), pushing_hand(), latency);
  const double error = rms_error(felt(pushed.lockstep, kTicks),
                                 integrate(pushing_hand(), kStiffness, mass, false, kTicks).force);
  CAPTURE(error);
  CHECK(error <= 0.05);
}

TEST_CASE("pushed body: a body in a corner is a wall, without a limit cycle", "[pushed]") {
  constexpr int kTicks = 2'500;  // the hand's own swing against a wall has died away
  const double stiffness = GENERATE(800.0, 3000.0);
  const double mass = GENERATE(0.005, 0.02, 2.0);
  const uint32_t latency = GENERATE(0u, 1u, 2u);
  CAPTURE(stiffness, mass, latency);
  PushedSession session(mass, stiffness);
  session.add_corner();
  Pushed pushed(session, pushing_hand(), latency);
  const std::vector<double> force = felt(pushed.lockstep, kTicks);
  const double error =
      rms_error(force, integrate(pushing_hand(), stiffness, mass, true, kTicks).force);
  CAPTURE(error, largest_step(force, 300));
  if (stiffness == 800.0) CHECK(error <= 0.2);
  CHECK(largest_step(force, 300) < 0.02);
}

TEST_CASE("pushed body: without the counters it is not so", "[pushed]") {
  constexpr double kStiffness = 1200, kMass = 0.005;  // as stiff as is not softened
  constexpr int kTicks = 1'000;
  const PushedSession session(kMass, kStiffness);
  const Integrated truth = integrate(pushing_hand(), kStiffness, kMass, false, kTicks);
  const auto error_of = [&](bool without_counters) {
    Pushed pushed(session, pushing_hand(), 2, without_counters);
    return rms_error(felt(pushed.lockstep, kTicks), truth.force);
  };
  const double with = error_of(false), without = error_of(true);
  CAPTURE(with, without);
  CHECK(with <= 0.005);
  CHECK(without > 0.01);
  CHECK(without > 5 * with);
}

TEST_CASE("pushed body: a tap returns no more energy than one against a fixed wall", "[pushed]") {
  constexpr int kTicks = 400;
  const double stiffness = GENERATE(800.0, 3000.0);
  const double mass = GENERATE(0.005, 0.02, 0.1, 1.0);
  const double rate = GENERATE(120.0, 1000.0);
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(stiffness, mass, rate, latency);
  const auto after_over_before = [&](bool is_free) {
    PushedSession session(is_free ? mass : 0, stiffness);
    session.config.sim_rate = rate;
    Pushed pushed(session, flying_hand(), latency);
    felt(pushed.lockstep, kTicks);
    const HandModel& now = pushed.hand.hand();
    const double body = is_free ? pushed.lockstep.scene().objects[0].V_WO.v.x : 0;
    return (kinetic(now.mass, now.v) + kinetic(mass, body)) / kinetic(now.mass, 0.3);
  };
  CHECK(after_over_before(true) <= 1.01 * after_over_before(false));
}

TEST_CASE("pushed body: what the hand gives is what the body has, whoever is killed meanwhile",
          "[pushed]") {
  constexpr double kMass = 0.05;
  PushedSession session(kMass, 800);
  const uint32_t latency = GENERATE(0u, 1u);
  Pushed pushed(session, pushing_hand(), latency);
  Lockstep& lockstep = pushed.lockstep;
  const int kill = GENERATE(0, 5, 60);  // ticks without sim, in mid-push
  const bool kills_servo = GENERATE(false, true);
  CAPTURE(kill, kills_servo, latency);
  double given = 0, forgotten_before = 0;
  for (int k = 0; k < 900; ++k) {
    if (k == 220 && kill > 0) lockstep.stop_sim();
    if (k == 220 + kill && kill > 0) lockstep.restart_sim();
    if (k == 260 && kills_servo) {
      // said in the servo's last frame, and by sim how much of it has been taken up
      const ServoFrame& last = lockstep.frame();
      const Vec3 seen_W = seen_of(lockstep.scene(), 0, kFirstHand)->impulse_W.f;
      forgotten_before = last.forgotten_impulse_W.x;
      if (kill > 260 - 220) forgotten_before += (last.pushes[0].impulse_W.f - seen_W).x;
      lockstep.restart_servo();
      lockstep.control().armed = 1;
    }
    REQUIRE(lockstep.step());
    given -= 1e-3 * lockstep.frame().F_coupling_W.f.x;
  }
  CHECK(given > 1e-3);
  const double forgotten = check_balance(lockstep, kMass, given, forgotten_before);
  if (kill == 0 && !kills_servo) CHECK(std::fabs(forgotten) < 1e-15);
}

TEST_CASE("pushed body: lockstep is the same bit for bit on two runs", "[pushed]") {
  const auto hash = [] {
    PushedSession session(0.02, 800);
    session.add_corner();
    Pushed pushed(session, pushing_hand());
    felt(pushed.lockstep, 600);
    return pushed.lockstep.hash();
  };
  CHECK(hash() == hash());
}

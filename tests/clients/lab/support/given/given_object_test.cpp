// SPDX-License-Identifier: GPL-3.0-or-later
// Objects that clients move, through contact, servo and sim: a right one is felt as it is, and one
// that lies with valid numbers gives the hand no more than it may.
#include <catch2/catch.hpp>
#include <random>

#include "tests/clients/lab/support/pushed_body.h"
#include "tests/sim/given/given_loop.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr int64_t kBeginNs = 1'000'000'000;  // of lockstep
constexpr Vec3 kPlace{0.03, 0, 0};           // of the box

/// The box of a pushed session, moved by a client.
PushedSession given_box(double stiffness) {
  PushedSession session(0, stiffness);
  session.config.n_clients = 1;
  session.config.clients[0].n_moves = 1;
  return session;
}

HandModel swinging_hand() {
  HandModel hand;
  hand.intent = [](double t) { return t < 1 ? -0.05 : 0.02 + 0.02 * std::sin(9 * t); };
  hand.x = -0.05;
  return hand;
}

/// A client's frame at a tick of lockstep, by the newest servo frame.
using Lie = std::function<void(const ServoFrame& servo, int n, GivenMotion& said)>;

struct Lied {
  double most_in_a_second = -1;  // given to the hand [J]
  double most_step = 0;          // of the force that is held [N], beyond slew and the hand's motion
  double most_force = 0;         // [N]
  uint32_t faults = 0;
};

Lied lied(const Lie& lie, int n_ticks) {
  PushedSession session = given_box(1500);
  session.config.safety = {};
  session.config.safety.max_force = 6;
  Pushed pushed(session, swinging_hand());
  Lockstep& lockstep = pushed.lockstep;
  Lied out;
  std::vector<double> given(1, 0);
  double x = pushed.hand.hand().x, force = 0;
  GivenFrame frame{};
  for (int n = 0; n < n_ticks; ++n) {
    if (n % 10 == 5 && n > 10) {
      GivenMotion said{};
      said.X_WO.p = kPlace;
      said.t_ns = frame.t_ns = lockstep.frame().t_ns;
      said.ticks[0] = lockstep.frame().tick;
      for (size_t i = 0; i < 3; ++i) said.mobility[7 * i] = 10;
      lie(lockstep.frame(), n, said);
      ++frame.seq;
      frame.moves.clear();
      frame.moves.push_back(said);
      lockstep.give(0, frame);
    }
    REQUIRE(lockstep.step());
    // the force of the tick before was held while the hand moved
    const double now = pushed.hand.hand().x, held = lockstep.frame().F_device_B.f.x;
    given.push_back(given.back() + force * (now - x));
    const double slewed = session.config.safety.slew * 1e-3;
    const double moved = session.config.coupling.translational_stiffness * std::fabs(now - x) + 2;
    out.most_step = std::max(out.most_step, std::fabs(held) - std::fabs(force) - slewed - moved);
    out.most_force = std::max(out.most_force, std::fabs(held));
    out.faults = std::max(out.faults, lockstep.frame().fault);
    if (n > 1000) {
      out.most_in_a_second =
          std::max(out.most_in_a_second, given.back() - given[given.size() - 1001]);
    }
    x = now;
    force = held;
  }
  return out;
}

}  // namespace

TEST_CASE("given object: through all of hapticd it is felt as one integrated at 20 µs is") {
  const double rate = GENERATE(100.0, 30.0);
  const GivenWorld world{.mass = 0.1, .stiffness = 500, .damping = 0.5};
  constexpr double kSpring = 1500;
  PushedSession session = given_box(kSpring);
  session.config.clients[0].max_force = 50;
  session.config.clients[0].max_power = 20;
  HandModel hand;
  hand.x = -0.02;
  hand.intent = [](double t) { return rise(-0.02, 0.05, 0.6)(t - 1); };
  Pushed pushed(session, hand);
  GivenClientBody client(world, {.rate = rate}, 0, kPlace);
  const int period = static_cast<int>(1000 / rate);
  std::vector<double> force;
  GivenFrame waiting{};
  for (int n = 0; n < 3000; ++n) {
    if (n > 0 && n % period == 0) {
      if (waiting.seq > 0) pushed.lockstep.give(0, waiting);  // a frame late
      waiting = client.frame(pushed.lockstep.frame(), kBeginNs + n * kMs);
    }
    REQUIRE(pushed.lockstep.step());
    force.push_back(-pushed.lockstep.frame().F_coupling_W.f.x);
  }
  // the judge: hand, one-sided spring and body as one
  GivenBody body;
  double sum = 0;
  for (int n = 0; n < 3000; ++n) {
    const double depth = hand.x - kFace - body.x, push = std::max(0.0, kSpring * depth);
    sum += (push - force[static_cast<size_t>(n)]) * (push - force[static_cast<size_t>(n)]);
    for (int i = 0; i < 50; ++i) {
      const double F = std::max(0.0, kSpring * (hand.x - kFace - body.x));
      hand.step(1e-3 * n + 2e-5 * i, -F, 2e-5);
      body.step(world, 2e-5, F);
    }
  }
  CAPTURE(rate, std::sqrt(sum / 3000), force.back());
  CHECK(std::sqrt(sum / 3000) <= 0.2);
  CHECK(force.back() == Approx(kSpring * (hand.x - kFace - body.x)).margin(0.1));
}

TEST_CASE("given object: what the hand gives is what its client's body has, whoever is killed") {
  const GivenWorld world{.mass = 0.05, .stiffness = 0, .damping = 0};
  HandModel hand;
  hand.x = -0.02;
  hand.intent = [](double t) { return rise(-0.02, 0.06, 0.5)(t - 0.4); };
  const int kill = GENERATE(0, 5, 60);  // ticks without sim, in mid-push
  const bool kills_contact = GENERATE(false, true);
  CAPTURE(kill, kills_contact);
  PushedSession session = given_box(800);
  session.config.sim_reach = 10;  // it flies off
  Pushed pushed(std::move(session), hand);
  Lockstep& lockstep = pushed.lockstep;
  GivenClientBody client(world, {}, 0, kPlace);
  double given = 0, most_moved = 0;
  GivenFrame waiting{};
  int64_t t_ns = kBeginNs;
  for (int n = 0; n < 1500; ++n, t_ns += kMs) {
    if (n == 700 && kill > 0) lockstep.stop_sim();
    if (n == 700 + kill && kill > 0) lockstep.restart_sim();
    if (n == 720 && kills_contact) lockstep.restart_contact();
    // sim has seen the tick that it has used a step later
    if (n > 1 && n % 10 == 1) lockstep.give(0, waiting);
    if (n > 0 && n % 10 == 0) waiting = client.frame(lockstep.frame(), t_ns);
    REQUIRE(lockstep.step());
    given -= 1e-3 * lockstep.frame().F_coupling_W.f.x;
    most_moved = std::max(most_moved, lockstep.scene().objects[0].X_WO.p.x - kPlace.x);
  }
  CHECK(lockstep.scene().givers[0].refused == 0);
  CHECK(most_moved > 1e-3);
  client.frame(lockstep.frame(), t_ns);
  const double has = world.mass * client.body.v;
  const double forgotten = lockstep.frame().forgotten_impulse_W.x;
  CAPTURE(given, has, forgotten);
  REQUIRE(given > 1e-3);
  CHECK(std::fabs(given - has - forgotten) <= 1e-9 * given);
  if (kill == 0) CHECK(forgotten == 0);
}

TEST_CASE("given object: who lies with valid numbers gives the hand no more than max_power") {
  // 10⁴ ticks of each in a normal run; HAPTIC_TORTURE_SCALE=100 gives 10⁶
  const int n_ticks = static_cast<int>(10'000 * torture_scale());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto towards = [](const ServoFrame& servo, double by) {
    return servo.X_WT.p + Vec3{kBoxEdge / 2 - by, 0, 0};
  };
  struct Named {
    const char* name;
    Lie lie;
  };
  const std::vector<Named> all{
      {"a hundredth of its mass",
       [](const ServoFrame&, int, GivenMotion& m) {
         for (size_t i = 0; i < 3; ++i) m.mobility[7 * i] = 1000;
       }},
      {"a millionth of its mass",
       [](const ServoFrame&, int, GivenMotion& m) {
         for (size_t i = 0; i < 3; ++i) m.mobility[7 * i] = 1e7;
       }},
      {"ticks of a second ago",
       [](const ServoFrame&, int n, GivenMotion& m) {
         if (n > 1100) m.ticks[0] -= 1000;
       }},
      {"jumps of 5 mm towards the tool",
       [&](const ServoFrame& servo, int n, GivenMotion& m) {
         if (n > 1500) m.X_WO.p = towards(servo, n % 20 == 5 ? 5e-3 : 0);
       }},
      {"a place that follows the hand and pushes it, driven",
       [&](const ServoFrame& servo, int n, GivenMotion& m) {
         m.power = 0.2;
         if (n > 1500) m.X_WO.p = towards(servo, 2e-3 * (servo.V_WT.v.x < 0 ? 1 : -1));
       }},
      {"a wall that moves with the hand, and no push moves it",
       [&](const ServoFrame& servo, int n, GivenMotion& m) {
         m.mobility = {};
         if (n > 1500) m.X_WO.p = towards(servo, servo.V_WT.v.x < 0 ? 3e-3 : -3e-3);
         m.V_WO.v.x = servo.V_WT.v.x;
       }},
      {"accelerations at random", [&](const ServoFrame&, int, GivenMotion& m) {
         m.acceleration_W.v.x = 1e4 * uniform(random);
         m.V_WO.v.x = 20 * uniform(random);
         m.X_WO.p.x += 5e-3 * uniform(random);
       }}};
  for (const Named& one : all) {
    const Lied result = lied(one.lie, n_ticks);
    CAPTURE(one.name, result.most_in_a_second, result.most_force, result.most_step);
    CHECK(result.most_in_a_second <= 0.2);
    CHECK(result.most_step <= 0);
    CHECK(result.most_force <= 6);
    CHECK(result.faults == 0);
  }
}

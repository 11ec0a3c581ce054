// SPDX-License-Identifier: GPL-3.0-or-later
// A grasp, in closed loop: what is held follows the hand, against an integration of the same
// equations at 20 µs, and what happens where somebody is away.
#include <catch2/catch.hpp>

#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/pushed_body.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kPress = 0.010;  // [s]
constexpr double kMove = 0.050;   // when the hand begins to move [s]

/// A hand 0.1 mm before the box that presses the button and moves it by `way` within 0.4 s.
HandModel carrying_hand(double way, double release) {
  HandModel hand;
  hand.x = kFace - 1e-4;
  const auto moves = rise(hand.x, way, 0.4);
  hand.intent = [=](double t) { return moves(t - kMove); };
  hand.presses = [=](double t) { return t >= kPress && t < release; };
  return hand;
}

PushedSession carrying_session(double mass, double stiffness) {
  PushedSession session(mass, stiffness);
  session.config.map.grasp_button = 0;
  return session;
}

double root_mean_square(const std::vector<double>& force) {
  return rms_error(force, std::vector<double>(force.size()));
}

bool holds(const Lockstep& lockstep) {
  return !lockstep.contacts()->guides.empty();
}

}  // namespace

TEST_CASE("grasp: a free body is carried as one integrated at 20 µs is", "[grasp]") {
  constexpr int kTicks = 500;
  const double stiffness = GENERATE(800.0, 3000.0);
  const double mass = GENERATE(0.02, 0.1, 0.5);
  const double way = GENERATE(0.05, -0.05);
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(stiffness, mass, way, latency);
  PushedSession session = carrying_session(mass, stiffness);
  Pushed pushed(session, carrying_hand(way, 1), latency);
  Lockstep& lockstep = pushed.lockstep;
  const std::vector<double> force = felt(lockstep, kTicks);
  const Integrated truth = integrate(carrying_hand(way, 1), stiffness, mass, false, kTicks);
  const double box = lockstep.scene().objects[0].X_WO.p.x - kBoxEdge / 2;
  CAPTURE(rms_error(force, truth.force), root_mean_square(truth.force), largest_step(force, 100));
  CAPTURE(box, truth.box, pushed.hand.hand().x, truth.hand);
  CHECK(rms_error(force, truth.force) <= 0.2);
  CHECK(std::fabs(box - truth.box) < 1e-3);
  CHECK(holds(lockstep));
}

TEST_CASE("grasp: a proxy with a radius, and a point that may enter, carry a body", "[grasp]") {
  constexpr int kTicks = 500;
  constexpr double kMass = 0.1, kRadius = 2e-3;
  const double stiffness = GENERATE(800.0, 3000.0);
  const Renderer renderer = GENERATE(Renderer::kVirtualProxy3, Renderer::kPenalty3);
  const double way = GENERATE(0.05, -0.05);
  CAPTURE(row_of(renderer).name, stiffness, way);
  PushedSession session = carrying_session(kMass, stiffness);
  session.config.renderer = renderer;
  session.config.proxy_radius = kRadius;
  const HandModel at_face = carrying_hand(way, 1);
  HandModel model = at_face;
  // the surface of the proxy is where the point of the other hand is
  const double back = renderer == Renderer::kVirtualProxy3 ? kRadius : 0;
  model.x -= back;
  model.intent = [=](double t) { return at_face.intent(t) - back; };
  Pushed pushed(session, model);
  Lockstep& lockstep = pushed.lockstep;
  const std::vector<double> force = felt(lockstep, kTicks);
  const Integrated truth = integrate(at_face, stiffness, kMass, false, kTicks);
  const double box = lockstep.scene().objects[0].X_WO.p.x - kBoxEdge / 2;
  CAPTURE(rms_error(force, truth.force), root_mean_square(truth.force), box, truth.box);
  CHECK(rms_error(force, truth.force) <= 0.05);
  CHECK(root_mean_square(truth.force) > 0.1);
  CHECK(std::fabs(box - truth.box) < 1e-3);
  CHECK(holds(lockstep));
}

TEST_CASE("grasp: without the counters a body that is carried buzzes", "[grasp]") {
  constexpr int kTicks = 500;
  constexpr double kStiffness = 3000, kMass = 0.02;
  PushedSession session = carrying_session(kMass, kStiffness);
  Pushed pushed(session, carrying_hand(0.05, 1), 2, true);
  Lockstep& lockstep = pushed.lockstep;
  const std::vector<double> force = felt(lockstep, kTicks);
  const Integrated truth = integrate(carrying_hand(0.05, 1), kStiffness, kMass, false, kTicks);
  CHECK(rms_error(force, truth.force) > 0.2);
}

TEST_CASE("grasp: a body that falls is caught and carried against gravity", "[grasp]") {
  constexpr int kTicks = 900;
  constexpr double kMass = 0.1, kFall = -9.81;  // towards the hand's side; [kg, m/s²]
  const double stiffness = GENERATE(800.0, 3000.0);
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(stiffness, latency);
  HandModel model = carrying_hand(0.05, 2);
  model.damping = 40;  // so that it comes to rest
  model.x = kFace - 1e-5;
  model.presses = [](double t) { return t >= 0.003; };  // it falls from the start
  PushedSession session = carrying_session(kMass, stiffness);
  // away from the hand: what catches it pulls
  session.config.gravity_W = {-kFall, 0, 0};
  session.config.coupling.translational_damping = 2;
  Pushed pushed(session, model, latency);
  Lockstep& lockstep = pushed.lockstep;
  const std::vector<double> force = felt(lockstep, kTicks);
  const std::vector<double> last(force.end() - 100, force.end());
  double mean = 0;
  for (const double f : last) mean += f / 100;
  CAPTURE(mean, largest_step(force, 100));
  CHECK(std::fabs(mean - kMass * kFall) < 0.05);
  CHECK(holds(lockstep));
}

TEST_CASE("grasp: a body that is let go of flies on with its twist", "[grasp]") {
  constexpr double kMass = 0.1, kRelease = 0.25;  // in mid-motion
  const double stiffness = GENERATE(800.0, 3000.0);
  const double way = GENERATE(0.05, -0.05);
  CAPTURE(stiffness, way);
  PushedSession session = carrying_session(kMass, stiffness);
  Pushed pushed(session, carrying_hand(way, kRelease));
  Lockstep& lockstep = pushed.lockstep;
  double before = 0, given = 0, last_force = 0;
  for (int k = 0; k < 253; ++k) {
    REQUIRE(lockstep.step());
    const double force = lockstep.frame().F_coupling_W.f.x;
    // what pushes goes on without a step
    if (way > 0 && k > 100) CHECK(std::fabs(force - last_force) < 0.2);
    last_force = force;
    const bool is_down = (lockstep.frame().device.buttons & 1) != 0;
    // a hand that pushes goes on pushing, as a hand does
    if (is_down) given -= 1e-3 * lockstep.frame().F_coupling_W.f.x;
    if (is_down) before = given / kMass;
    if (!is_down && way < 0) CHECK(lockstep.frame().F_coupling_W.f.x == 0);
  }
  REQUIRE(std::fabs(before) > 0.05);
  if (way < 0) CHECK(std::fabs(lockstep.scene().objects[0].V_WO.v.x - before) < 1e-9);
  for (int k = 0; k < 10; ++k) REQUIRE(lockstep.step());
  CHECK(!holds(lockstep));
}

TEST_CASE("grasp: what the hand gives is what the body has, whoever is killed meanwhile",
          "[grasp]") {
  constexpr double kMass = 0.05;
  PushedSession session = carrying_session(kMass, 800);
  const uint32_t latency = GENERATE(0u, 1u);
  Pushed pushed(session, carrying_hand(GENERATE(0.05, -0.05), 0.4), latency);
  Lockstep& lockstep = pushed.lockstep;
  const int kill = GENERATE(0, 5, 60);  // ticks without sim, while the body is carried
  const bool kills_contact = GENERATE(false, true);
  CAPTURE(kill, kills_contact, latency);
  double given = 0;
  for (int k = 0; k < 600; ++k) {
    if (k == 220 && kill > 0) lockstep.stop_sim();
    if (k == 220 + kill && kill > 0) lockstep.restart_sim();
    if (k == 300 && kills_contact) lockstep.stop_contact();
    if (k == 340 && kills_contact) lockstep.restart_contact();
    REQUIRE(lockstep.step());
    given -= 1e-3 * lockstep.frame().F_coupling_W.f.x;
  }
  check_balance(lockstep, kMass, given);
}

TEST_CASE("grasp: what cannot move holds the hand as the coupling's spring, let in over 200 ms",
          "[grasp]") {
  constexpr double kStiffness = 800;
  PushedSession session = carrying_session(0, kStiffness);
  Pushed pushed(session, carrying_hand(-0.02, 2));
  Lockstep& lockstep = pushed.lockstep;
  int n_held = 0;  // ticks
  double most_pull = 0;
  for (int k = 0; k < 600; ++k) {
    REQUIRE(lockstep.step());
    if (k > 0 && holds(lockstep)) ++n_held;
    // held where the proxy was, 0.1 mm before the face
    const double stretch = kFace - 1e-4 - lockstep.frame().X_WT.p.x;
    const double force = lockstep.frame().F_coupling_W.f.x;
    CHECK(std::fabs(force - std::min(n_held / 200.0, 1.0) * kStiffness * stretch) < 0.01);
    most_pull = std::max(most_pull, force);
  }
  CHECK(n_held > 550);
  CHECK(most_pull > 1);
}

TEST_CASE("grasp: no step of force when the button goes down, nor while it is let in",
          "[grasp][trap]") {
  constexpr double kStiffness = 800;
  const double mass = GENERATE(0.0, 2.0);
  HandModel model;
  // leans against the box, 4 mm into it and at rest, and then withdraws
  const auto leaves = rise(kFace + 0.004 * (1 + kStiffness / model.stiffness), -0.03, 0.3);
  model.x = kFace + 0.004;
  model.intent = [=](double t) { return leaves(t - 0.3); };
  model.presses = [](double t) { return t >= 0.05; };
  PushedSession session = carrying_session(mass, kStiffness);
  Pushed pushed(session, model);
  Lockstep& lockstep = pushed.lockstep;
  std::vector<double> force;
  std::vector<double> way;
  double before = model.x;
  for (int k = 0; k < 700; ++k) {
    REQUIRE(lockstep.step());
    force.push_back(-lockstep.frame().F_coupling_W.f.x);
    way.push_back(std::fabs(lockstep.frame().X_WT.p.x - before));
    before = lockstep.frame().X_WT.p.x;
  }
  // a spring changes by its stiffness times the relative motion, and 1/200 of a pull per tick
  for (size_t k = 40; k < force.size(); ++k) {
    const double moved = way[k] + (mass > 0 ? 1e-3 * 0.5 : 0);
    CAPTURE(k, force[k - 1], force[k], way[k]);
    CHECK(std::fabs(force[k] - force[k - 1]) <=
          kStiffness * moved + 0.01 + std::fabs(force[k]) / 200);
  }
  if (mass == 0) CHECK(std::fabs(force[200] - force[49]) < 0.05);
  if (mass == 0) CHECK(force.back() < -1);
}

TEST_CASE("grasp: contact is killed while the body is held: its rows fade, and nothing is held",
          "[grasp]") {
  const double mass = GENERATE(0.0, 0.1);
  PushedSession session = carrying_session(mass, 800);
  Pushed pushed(session, carrying_hand(-0.02, 2));
  Lockstep& lockstep = pushed.lockstep;
  std::vector<double> force;
  for (int k = 0; k < 900; ++k) {
    if (k == 400) lockstep.stop_contact();
    if (k == 600) lockstep.restart_contact();
    REQUIRE(lockstep.step());
    force.push_back(lockstep.frame().F_coupling_W.f.x);
    // full for 20 ms, gone within 50 more
    if (k > 475 && k < 600) CHECK(force.back() == 0);
    if (k > 402 && k < 600)
      CHECK(std::fabs(force.back()) <= std::fabs(force[static_cast<size_t>(k) - 1]) + 0.1);
  }
  CHECK(!holds(lockstep));
}

TEST_CASE("grasp: sim is killed while the body is held: it is carried again", "[grasp]") {
  constexpr double kMass = 0.1, kStiffness = 800, kWay = 0.05;
  const int away = GENERATE(10, 40, 300);  // [ticks]
  const uint32_t latency = GENERATE(0u, 2u);
  CAPTURE(away, latency);
  PushedSession session = carrying_session(kMass, kStiffness);
  HandModel model = carrying_hand(kWay, 3);
  model.damping = 40;
  Pushed pushed(session, model, latency);
  Lockstep& lockstep = pushed.lockstep;
  double before = 0, fastest = 0, most = 0;
  for (int k = 0; k < 1500; ++k) {
    if (k == 220) lockstep.stop_sim();
    if (k == 220 + away) lockstep.restart_sim();
    REQUIRE(lockstep.step());
    const double force = std::fabs(lockstep.frame().F_coupling_W.f.x);
    if (k > 220) fastest = std::max(fastest, force - before);
    most = std::max(most, force);
    before = force;
  }
  CAPTURE(most, fastest);
  // what stands in the hand's way pushes it as a wall does
  CHECK(most < 6);
  // a hand of at most 0.25 m/s
  CHECK(fastest < kStiffness * 0.25e-3 + 0.1);
  CHECK(holds(lockstep));
  const double box = lockstep.scene().objects[0].X_WO.p.x - kBoxEdge / 2;
  CHECK(std::fabs(box - lockstep.frame().X_WT.p.x) < 5e-3);
}

TEST_CASE("grasp: a button that is down at the start, or touches nothing, holds nothing",
          "[grasp][trap]") {
  PushedSession session = carrying_session(0.1, 800);
  HandModel model = carrying_hand(0.05, 2);
  SECTION("down at the start") {
    model.presses = [](double) { return true; };
  }
  SECTION("a millimetre away") {
    model.x -= 1e-3;
    model.intent = [=](double) { return model.x; };
  }
  SECTION("no button is named") {
    session.config.map.grasp_button = -1;
  }
  Pushed pushed(session, model);
  Lockstep& lockstep = pushed.lockstep;
  for (int k = 0; k < 100; ++k) {
    REQUIRE(lockstep.step());
    const ContactSet* set = lockstep.contacts();
    REQUIRE((set == nullptr || set->guides.empty()));
  }
}

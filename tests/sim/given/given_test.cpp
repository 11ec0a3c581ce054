// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for sim/given: objects that clients move.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "sim/given/guarded_model.h"
#include "sim/given/statement.h"
#include "sim/pushes/push_history.h"
#include "tests/sim/body_scene.h"
#include "tests/sim/given/given_loop.h"

using namespace haptic;
using namespace haptic::test;

namespace {

struct Case {
  const char* name;
  GivenWorld world;
};
const std::vector<Case> kRight{{"20 g on 500 N/m", {.mass = 0.02}},
                               {"100 g on 500 N/m", {}},
                               {"200 g on 100 N/m", {.mass = 0.2, .stiffness = 100}}};

GivenResult ran(const GivenWorld& world, const GivenClientRun& run, Motion motion) {
  return run_given(world, run, motion, judge(world, motion, run.seconds));
}

GivenMotion still_motion() {
  GivenMotion said{};
  said.t_ns = kStartNs;
  for (size_t i = 0; i < 3; ++i) said.mobility[7 * i] = 10;
  return said;
}

/// A session of one object and one client, moved from outside.
struct Stage {
  SimModel model = build_sim(given_session());
  SimState state{model};
  ServoFrame servo{};
  int64_t t_ns = kStartNs;
  uint64_t seq = 0;
  uint64_t generation = 1;

  Stage() {
    servo.impulses_since_ns = kStartNs;
    servo.pushes.resize(1);
  }
  SceneFrame step() {
    t_ns += kMs;
    ++servo.tick;
    servo.t_ns = t_ns;
    see_hand(model.given, state.given, 0, servo);
    return sim_step(model, state, {&servo}, t_ns);
  }
  void give(GivenMotion said) {
    said.t_ns = t_ns;
    said.ticks[0] = servo.tick;
    GivenFrame frame{};
    frame.seq = ++seq;
    frame.t_ns = t_ns;
    frame.moves.push_back(said);
    set_giving(model.given, state.given, 0, generation);
    see_client(model.given, state.given, 0, generation, frame, t_ns);
  }
  GiverState told() const { return state.given.clients[0].heard.report(0, t_ns); }
};

}  // namespace

TEST_CASE("given: a body that its client integrates late is felt as if it were here") {
  struct Sent {
    double rate, jitter;
  };
  for (const Case& one : kRight) {
    for (const Sent& sent : {Sent{100, 0}, {100, 1}, {60, 0}, {30, 0}}) {
      INFO(one.name << ", " << sent.rate << " Hz, jitter " << sent.jitter);
      const GivenClientRun run{.rate = sent.rate, .jitter = sent.jitter, .seconds = 4};
      const GivenResult held = ran(one.world, run, Motion::kHold);
      CHECK(held.cycle <= 0.2);
      CHECK(held.rms <= 0.2);
      CHECK(held.gained <= 1e-3);
      CHECK(held.least_share == 1);
      CHECK_FALSE(held.is_said);
      const GivenResult tapped = ran(one.world, run, Motion::kTap);
      CHECK(tapped.back <= 1.05);
      CHECK(tapped.least_share == 1);
    }
    INFO(one.name << ", twenty seconds of taps");
    const GivenResult taps = ran(one.world, {.rate = 30}, Motion::kTaps);
    CHECK(taps.gained <= 1e-3);
    CHECK(taps.least_share == 1);
  }
}

TEST_CASE("given: an object that is not as its client says turns into clay, and it is said") {
  // a wall or a body behind it that are not stated, dry friction, 30 % of mass and of stiffness
  const GivenWorld world, soft{.stiffness = 100};
  GivenWorld wall = soft, second = soft, dry;
  wall.wall = 2e-3;
  wall.wall_stiffness = 5000;
  second.second = 0.05;
  dry.dry = 0.3;
  struct Wrong {
    const char* name;
    GivenWorld world;
    double mass = 1, stiffness = 1;
  };
  const std::vector<Wrong> all{{"mass 0.7", world, 0.7},          {"mass 1.3", world, 1.3},
                               {"stiffness 0.7", world, 1, 0.7},  {"stiffness 1.3", world, 1, 1.3},
                               {"stiffness unsaid", world, 1, 0}, {"a wall", wall},
                               {"a second body", second},         {"friction", dry}};
  for (const Wrong& wrong : all) {
    for (const double rate : {100.0, 30.0, 10.0}) {
      INFO(wrong.name << ", " << rate << " Hz");
      const GivenClientRun run{.rate = rate,
                               .jitter = rate > 60 ? 1.0 : 0.0,
                               .mass_said = wrong.mass,
                               .stiffness_said = wrong.stiffness,
                               .seconds = 5};
      const GivenResult held = ran(wrong.world, run, Motion::kHold);
      CHECK(held.cycle <= 0.5);
      CHECK(held.gained <= 12e-3);
      CHECK(held.step <= 2);
      if (std::string(wrong.name) == "a wall" || wrong.stiffness == 0) CHECK(held.is_said);
    }
  }
}

TEST_CASE("given: right statements at 10 Hz are not held back") {
  const GivenClientRun run{.rate = 10, .seconds = 6};
  for (const Case& one : kRight) {
    INFO(one.name);
    const GivenResult held = ran(one.world, run, Motion::kHold);
    CHECK(held.cycle <= 0.2);
    CHECK(held.rms <= 0.25);
    CHECK_FALSE(held.is_said);
  }
}

TEST_CASE("given: a right statement is not held back where max_force cuts what is felt") {
  const GivenResult pressed = ran({}, {.seconds = 6, .max_force = 2}, Motion::kHold);
  CHECK_FALSE(pressed.ran_away);
  CHECK_FALSE(pressed.is_said);
  CHECK(pressed.cycle < 0.1);
}

namespace {

/// A bob on a rod in a plane, as its client integrates it: exactly, by its angle.
struct Bob {
  static constexpr double kMass = 0.15, kRod = 0.3, kG = 9.81;
  double angle = 0.6, speed = 0;

  void step(double dt) {
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps; ++i) {
      speed -= dt / kSteps * kG / kRod * std::sin(angle);
      angle += dt / kSteps * speed;
    }
  }
  Vec3 place() const { return kRod * Vec3{std::sin(angle), 0, 1 - std::cos(angle)}; }
  GivenMotion said() const {
    const Vec3 along{std::cos(angle), 0, std::sin(angle)}, up{-std::sin(angle), 0, std::cos(angle)};
    GivenMotion motion{};
    motion.X_WO.p = place();
    motion.V_WO.v = kRod * speed * along;
    motion.acceleration_W.v = -kG * std::sin(angle) * along + kRod * speed * speed * up;
    const double a[3] = {along.x, along.y, along.z};
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) {
        motion.mobility[6 * i + j] = a[i] * a[j] / kMass;
        motion.stiffness[6 * i + j] = a[i] * a[j] * kMass * kG / kRod;
      }
    }
    return motion;
  }
};

}  // namespace

TEST_CASE("given: a bob that is touched stays on its rod, however little its frames may do") {
  Bob bob;
  GuardedModel model;
  model.place({bob.said().X_WO, bob.said().V_WO}, bob.said());
  double farthest = 0, off_rod = 0;
  for (int tick = 1; tick <= 6000; ++tick) {
    bob.step(1e-3);
    // in touch all the time, by a hand that takes what the purse has
    HandsOnObject hands;
    hands.impulse_W.f.y = 1e-9;
    hands.work = -1e-5;
    hands.stiffness = 800;
    model.step(hands, 1e-3);
    if (tick % 10 == 0) model.correct({bob.said().X_WO, bob.said().V_WO}, bob.said(), 10);
    const Vec3 p = model.at().X_WO.p;
    farthest = std::max(farthest, norm(p - bob.place()));
    off_rod = std::max(off_rod, std::fabs(norm(p - Vec3{0, 0, Bob::kRod}) - Bob::kRod));
  }
  CAPTURE(farthest, off_rod);
  // no farther than the bob swings
  CHECK(farthest < 2.2 * Bob::kRod * std::sin(0.6));
  CHECK(off_rod < 0.15);
}

TEST_CASE("given: what moves along a rail in any direction may be said") {
  for (int k = 0; k < 3600; ++k) {
    const double angle = k * M_PI / 1800;
    const double a[3] = {std::cos(angle), std::sin(angle), 0};
    GivenMotion said = still_motion();
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) said.mobility[6 * i + j] = a[i] * a[j] / 0.15;
    }
    CAPTURE(k);
    REQUIRE(refusal_of(said) == GiverRefusal::kNone);
    // and in a plane across it, with the rounding of 1 − n²
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) said.mobility[6 * i + j] = ((i == j) - a[i] * a[j]) / 0.15;
    }
    REQUIRE(refusal_of(said) == GiverRefusal::kNone);
  }
}

TEST_CASE("given: placed by its frames alone, the first body runs away") {
  const GivenClientRun run{.seconds = 6, .has_model = false};
  const GivenResult result = ran(kRight[0].world, run, Motion::kHold);
  CHECK((result.ran_away || result.cycle > 5));
}

TEST_CASE("given: a client that leaves S out is felt worse") {
  const GivenClientRun run{.rate = 30, .seconds = 6},
      mean{.rate = 30, .seconds = 6, .uses_integral = false};
  const GivenWorld& world = kRight[0].world;
  CHECK(ran(world, mean, Motion::kTaps).rms > ran(world, run, Motion::kTaps).rms);
}

TEST_CASE("given: an object stands, is let go, follows, fades and comes back") {
  Stage stage;
  SceneFrame scene = stage.step();
  CHECK(scene.objects[0].mover == kMovedBySim);
  CHECK(scene.objects[0].reduction == 0);
  CHECK_FALSE(is_mobile(scene, 0));
  GivenMotion said = still_motion();
  said.X_WO.p.x = 0.03;
  // fifty milliseconds until nothing is felt, and as long until all is
  const auto run = [&](int n, bool gives) {
    for (int i = 0; i < n; ++i) {
      if (gives && i % 10 == 0) stage.give(said);
      scene = stage.step();
    }
  };
  run(45, true);
  CHECK(scene.objects[0].reduction > 0.8);
  CHECK(scene.objects[0].X_WO.p.x == 0);  // what is felt does not jump
  run(150, true);
  CHECK(scene.objects[0].mover == moved_by_client(0));
  CHECK(scene.objects[0].reduction == 0);
  CHECK(scene.objects[0].X_WO.p.x == Approx(0.03));
  CHECK(is_mobile(scene, 0));
  // three periods of 10 ms, and then 50 ms of fading
  run(19, false);  // the last frame came ten before
  CHECK(scene.objects[0].reduction == 0);
  run(25, false);
  CHECK(scene.objects[0].reduction > 0.2);
  CHECK(scene.objects[0].reduction < 0.8);
  run(40, false);
  CHECK(scene.objects[0].reduction == 1);
  CHECK((scene.givers[0].flags & kGiverLate) != 0);
  run(41, true);
  CHECK(scene.objects[0].reduction > 0.9);  // five fresh frames first
  run(80, true);
  CHECK(scene.objects[0].reduction == 0);
}

TEST_CASE("given: each lie of a frame is refused with its reason") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto refusal = [](const std::function<void(GivenMotion&)>& change) {
    GivenMotion said = still_motion();
    change(said);
    return refusal_of(said);
  };
  using enum GiverRefusal;
  CHECK(refusal([](GivenMotion&) {}) == kNone);
  CHECK(refusal([](GivenMotion& m) { m.X_WO.p.x = kNan; }) == kNotFinite);
  CHECK(refusal([](GivenMotion& m) { m.V_WO.w.y = HUGE_VAL; }) == kNotFinite);
  CHECK(refusal([](GivenMotion& m) { m.X_WO.q.w = 2; }) == kNotFinite);
  CHECK(refusal([](GivenMotion& m) { m.X_WO.q = {0, 0, 0, 0}; }) == kNotFinite);
  CHECK(refusal([](GivenMotion& m) { m.stiffness[3] = kNan; }) == kNotFinite);
  CHECK(refusal([](GivenMotion& m) { m.V_WO.v.x = 1e300; }) == kTooFast);
  CHECK(refusal([](GivenMotion& m) { m.X_WO.p.z = 1e6; }) == kTooFast);
  CHECK(refusal([](GivenMotion& m) { m.mobility[1] = 5; }) == kNotSymmetric);
  CHECK(refusal([](GivenMotion& m) { m.mobility[1] = m.mobility[6] = 20; }) == kNotSymmetric);
  CHECK(refusal([](GivenMotion& m) { m.stiffness[0] = -1; }) == kNotSymmetric);
  CHECK(refusal([](GivenMotion& m) { m.damping[35] = -1e-9; }) == kNotSymmetric);
  CHECK(refusal([](GivenMotion& m) { m.mobility[0] = 1e7; }) == kTooLight);
  CHECK(refusal([](GivenMotion& m) { m.stiffness[0] = 1e6; }) == kTooStiff);
  CHECK(refusal([](GivenMotion& m) { m.damping[0] = 1e4; }) == kTooStiff);
  // nothing of these may become infinite, whatever answers
  CHECK(refusal([](GivenMotion& m) {
          m.mobility = {};
          m.damping[0] = 1.7e308;
        }) == kTooStiff);
  CHECK(refusal([](GivenMotion& m) {
          m.mobility = {};
          m.stiffness[35] = 1.7e308;
        }) == kTooStiff);
  CHECK(refusal([](GivenMotion& m) { m.mobility[7] = 1e-7; }) == kTooLight);
  // a negative direction of moving is seen beside a much larger mobility of turning
  CHECK(refusal([](GivenMotion& m) {
          m.mobility[21] = m.mobility[28] = m.mobility[35] = 1e8;
          m.mobility[1] = m.mobility[6] = 11;
        }) == kNotSymmetric);
}

TEST_CASE("given: frames out of their time, of others' objects and of unknown ticks are refused") {
  Stage stage;
  for (int n = 0; n < 200; ++n) stage.step();
  const auto refusal = [&](const std::function<void(GivenFrame&)>& change) {
    GivenFrame frame{};
    frame.seq = ++stage.seq;
    frame.t_ns = stage.t_ns;
    GivenMotion said = still_motion();
    said.t_ns = stage.t_ns;
    said.ticks[0] = stage.servo.tick;
    frame.moves.push_back(said);
    change(frame);
    set_giving(stage.model.given, stage.state.given, 0, 1);
    see_client(stage.model.given, stage.state.given, 0, 1, frame, stage.t_ns);
    const auto why = static_cast<GiverRefusal>(stage.told().refusal);
    stage.step();
    stage.step();  // two milliseconds
    return why;
  };
  using enum GiverRefusal;
  CHECK(refusal([](GivenFrame&) {}) == kNone);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].object = 7; }) == kNotAllowed);
  CHECK(refusal([](GivenFrame& f) { f.t_ns += 20 * kMs; }) == kBackInTime);
  CHECK(refusal([](GivenFrame& f) { f.t_ns -= 20 * kMs; }) == kBackInTime);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].t_ns -= 600 * kMs; }) == kBackInTime);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].t_ns += 20 * kMs; }) == kBackInTime);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].ticks[0] += 1; }) == kUnknownTick);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].ticks[0] = 1; }) == kUnknownTick);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].ticks[0] += 1000; }) == kUnknownTick);
  CHECK(refusal([](GivenFrame& f) { f.moves[0].ticks[0] -= 150; }) == kUnknownTick);
  CHECK(stage.told().refused == 9);
  CHECK(refusal([](GivenFrame&) {}) == kNone);
  // nothing of a refused frame is taken: the object is where the good ones have it
  CHECK(stage.step().objects[0].X_WO.p == Vec3{});
}

TEST_CASE("given: a servo that begins anew is believed, and who leaves or changes is let go") {
  Stage stage;
  const GivenMotion said = still_motion();
  SceneFrame scene;
  const auto run = [&](int n, const GivenMotion& motion) {
    for (int i = 0; i < n; ++i) {
      if (i % 10 == 0) stage.give(motion);
      scene = stage.step();
    }
  };
  run(300, said);
  REQUIRE(scene.objects[0].reduction == 0);
  stage.servo.tick = 0;
  stage.servo.impulses_since_ns = stage.t_ns;
  run(20, said);
  // its very first tick may not be known yet
  CHECK(stage.told().refused <= 2);  // at both starts, before a tick was known
  CHECK(stage.told().refusal == 0);
  CHECK(scene.objects[0].reduction == 0);
  // elsewhere, and no push moves it any more: what is felt does not jump there
  GivenMotion wall = said;
  wall.mobility = {};
  wall.X_WO.p.x = 0.5;
  run(20, wall);
  CHECK(scene.objects[0].X_WO.p.x < 1e-3);
  CHECK(scene.objects[0].reduction > 0.2);
  run(200, wall);
  CHECK(scene.objects[0].X_WO.p.x == Approx(0.5));
  CHECK(scene.objects[0].reduction == 0);
  set_giving(stage.model.given, stage.state.given, 0, 0);
  for (int i = 0; i < 60; ++i) scene = stage.step();
  CHECK(scene.objects[0].reduction == 1);
}

TEST_CASE(
    "given: what a client has given the hand is a client's power, and too much of it is cut") {
  Stage stage;
  stage.model.given.clients[0].config.max_power = 0.2;
  GivenMotion said = still_motion();
  SceneFrame scene;
  for (int n = 0; n < 300; ++n) {
    if (n % 10 == 0) stage.give(said);
    scene = stage.step();
  }
  CHECK(scene.objects[0].reduction == 0);
  // it pushes a hand that moves away at 1 m/s with 2 N: 2 W
  double given = 0;
  for (int n = 0; n < 500; ++n) {
    stage.servo.X_WT.p.z += 1e-3;
    const double force = 2 * (1 - scene.objects[0].reduction);
    stage.servo.pushes[0].impulse_W.f.z -= kTick * force;
    given += kTick * force;
    if (n % 10 == 0) stage.give(said);
    scene = stage.step();
  }
  CHECK(given < 0.2);
  CHECK(scene.objects[0].reduction == 1);
  CHECK((scene.givers[0].flags & kGiverCut) != 0);
}

TEST_CASE("given: what sim's bodies push an object of a client with is counted") {
  // a box of 100 g falls by 1 mm on a plate that a client may move, and lies there
  BodyScene scene;
  scene.config.gravity_W = {0, 0, -kGravity};
  scene.add_box({0.1, 0.1, 0.01}, {{0, 0, -0.005}, {}}, 0);
  scene.add_box({0.02, 0.02, 0.02}, {{0.02, 0, 0.011}, {}}, 0.1);
  scene.config.n_clients = 1;
  scene.config.clients[0].n_moves = 1;
  SimModel model = build_sim(scene.config, scene.shapes);
  SimState state(model);
  int64_t t_ns = kStartNs;
  SceneFrame frame = sim_step(model, state, t_ns);
  constexpr int kTicks = 1000;
  for (int n = 0; n < kTicks; ++n) frame = sim_step(model, state, t_ns += kMs);
  REQUIRE(frame.world_pushes.size() == 1);
  const Wrench& J_W = frame.world_pushes[0].impulse_W;
  // all of its weight in that time, at 20 mm from the plate's middle
  const double weight = 0.1 * kGravity * kTicks * kTick;
  CHECK(J_W.f.z == Approx(-weight).epsilon(0.01));
  CHECK(std::hypot(J_W.f.x, J_W.f.y) < 0.01 * weight);
  CHECK(J_W.t.y == Approx(0.02 * weight).epsilon(0.03));
}

TEST_CASE("given: a history knows its ticks, forgets the oldest and begins anew with a servo") {
  PushHistory history(1, 0);
  ServoFrame frame{};
  frame.pushes.resize(1);
  frame.impulses_since_ns = 5;
  for (uint64_t tick = 10; tick < 5010; tick += 2) {
    frame.tick = tick;
    frame.t_ns = static_cast<int64_t>(tick) * kMs;
    frame.pushes[0].impulse_W.f.x = static_cast<double>(tick);
    history.add(frame);
  }
  const auto found = history.find(4000);
  REQUIRE(found);
  CHECK(history.push(*found, 0).impulse_W.f.x == 4000);
  CHECK_FALSE(history.find(4001));
  CHECK_FALSE(history.find(6000));
  for (uint64_t tick = 5010; tick < 9210; ++tick) {
    frame.tick = tick;
    history.add(frame);
  }
  CHECK_FALSE(history.find(4000));
  CHECK(history.find(9209));
  frame.impulses_since_ns = 6;
  frame.tick = 3;
  history.add(frame);
  CHECK_FALSE(history.find(9209));
  CHECK(history.find(3));
  CHECK(history.end() - history.begin() == 1);
  frame.pushes[0].impulse_W.f.x = std::nan("");
  frame.tick = 4;
  history.add(frame);
  CHECK_FALSE(history.find(4));
}

TEST_CASE("given: a sim that was away lets the object stand until its client is heard again") {
  Stage stage;
  GivenMotion said = still_motion();
  said.X_WO.p.x = 0.02;
  SceneFrame scene;
  for (int n = 0; n < 300; ++n) {
    if (n % 10 == 0) stage.give(said);
    scene = stage.step();
  }
  REQUIRE(scene.objects[0].reduction == 0);
  stage.state = SimState(stage.model);
  resume(stage.model, stage.state, scene);
  scene = stage.step();
  CHECK(scene.objects[0].X_WO.p.x == Approx(0.02));
  CHECK(scene.objects[0].reduction == 1);
  for (int n = 0; n < 200; ++n) {
    if (n % 10 == 0) stage.give(said);
    scene = stage.step();
  }
  CHECK(scene.objects[0].reduction == 0);
}

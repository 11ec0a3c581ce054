// SPDX-License-Identifier: GPL-3.0-or-later
// Several hands at one scene, against an integration of the same equations at 20 µs.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <memory>
#include <vector>

#include "proto/config/hand_config.h"
#include "proto/config/renderer_needs.h"
#include "tests/clients/lab/support/pushed_body.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kStiffness = 800;  // of each coupling [N/m]
constexpr double kDamping = 1;      // [N·s/m]

/// Hands around the box of a PushedSession: the first pushes along x, the second against it, the
/// third and fourth along y and against it. Each has a base of its own, in which it pushes along x.
class Hands {
 public:
  Hands(double mass, std::vector<HandModel> models, LockstepOptions of_second = {},
        double second_rate = 1000)
      : session_(mass, kStiffness) {
    const auto n = static_cast<uint32_t>(models.size());
    for (uint32_t k = 0; k < n; ++k) {
      SessionConfig& config = configs_.emplace_back(session_.config);
      config.hand = k;
      config.n_hands = n;
      config.sim_reach = 1e3;
      config.coupling.translational_damping = kDamping;
      if (k == 1) config.servo_rate = second_rate;
      constexpr std::array kTurns{0.0, M_PI, M_PI / 2, -M_PI / 2};
      const Quat q = from_rotation_vector({0, 0, kTurns.at(k)});
      // 30 mm from the middle of the box, as the first is
      config.map.X_WB = {session_.config.objects[0].X_WO.p - rotate(q, Vec3{0.03, 0, 0}), q};
      devices_.emplace_back(std::move(models[k]));
    }
    std::vector<LockstepHand> parts;
    for (uint32_t k = 0; k < n; ++k) {
      parts.push_back({configs_[k], shapes_, devices_[k], k == 1 ? of_second : LockstepOptions{}});
    }
    lockstep_ = std::make_unique<Lockstep>(std::span<const LockstepHand>(parts));
  }
  Lockstep& lockstep() { return *lockstep_; }
  PushingHand& device(size_t k) { return devices_[k]; }

 private:
  PushedSession session_;
  ContactShapes shapes_{session_.shapes};
  std::deque<SessionConfig> configs_;
  std::deque<PushingHand> devices_;
  std::unique_ptr<Lockstep> lockstep_;
};

HandModel hand_that(std::function<double(double)> intent) {
  HandModel hand;
  hand.intent = std::move(intent);
  return hand;
}

/// Both press the box by 10 N at most, the first a tenth of a second longer and further.
std::vector<HandModel> both_press() {
  return {hand_that(rise(0, 0.06, 0.4)), hand_that(rise(0, 0.05, 0.5))};
}

struct TwoForces {
  std::vector<double> first, second;  // at each tick [N]
};

/// The motion from its definition: two hands on a line, two one-sided springs with dampers, a box
/// between. The second hand begins half a tick later, as it ticks.
TwoForces integrate_two(std::vector<HandModel> hands, double mass, int n_ticks) {
  constexpr double kFineStep = 20e-6;
  constexpr int kSteps = 50;  // in a tick
  TwoForces out;
  double x = 0, v = 0;  // of the box from its place
  for (int k = 0; k < kSteps * n_ticks; ++k) {
    const double t = k * kFineStep;
    const auto pressed = [](double depth, double closing) {
      return depth > 0 ? std::max(kStiffness * depth + kDamping * closing, 0.0) : 0.0;
    };
    const double push = pressed(hands[0].x - kFace - x, hands[0].v - v);
    const double back = pressed(hands[1].x - kFace + x, hands[1].v + v);
    if (k % kSteps == 0) out.first.push_back(push);
    if (k % kSteps == kSteps / 2) out.second.push_back(back);
    hands[0].step(t, -push, kFineStep);
    if (k >= kSteps / 2) hands[1].step(t - kSteps / 2 * kFineStep, -back, kFineStep);
    v += kFineStep * (push - back) / mass;
    x += kFineStep * v;
  }
  return out;
}

/// Force on a hand along its own x, against the way that it pushes [N].
double force_on(const Lockstep& lockstep, uint32_t hand) {
  return -lockstep.frame(hand).F_device_B.f.x;
}

}  // namespace

TEST_CASE("two hands: a body between them pushes both as one integrated at 20 µs does",
          "[pushed][hands]") {
  constexpr int kTicks = 1500;
  const double mass = GENERATE(0.02, 0.2, 2.0);
  CAPTURE(mass);
  Hands hands(mass, both_press());
  const TwoForces truth = integrate_two(both_press(), mass, kTicks);
  double squares = 0;
  for (int k = 0; k < kTicks; ++k) {
    REQUIRE(hands.lockstep().step());
    const auto at = static_cast<size_t>(k);
    squares += std::pow(force_on(hands.lockstep(), 0) - truth.first[at], 2);
    // its tick is half a period after the first's, of which it has had those before
    if (k > 0) squares += std::pow(force_on(hands.lockstep(), 1) - truth.second[at - 1], 2);
  }
  const double error = std::sqrt(squares / (2 * kTicks));
  CAPTURE(error);
  CHECK(*std::max_element(truth.second.begin(), truth.second.end()) > 3);
  CHECK(error <= 0.1);
}

TEST_CASE("two hands: a body squeezed between them comes to rest", "[pushed][hands]") {
  const double mass = GENERATE(0.005, 0.02, 0.2);
  const double second_rate = GENERATE(1000.0, 4000.0);
  CAPTURE(mass, second_rate);
  Hands hands(mass, both_press(), {}, second_rate);
  for (int k = 0; k < 3000; ++k) REQUIRE(hands.lockstep().step());
  double least = 1e9, most = 0;
  for (int k = 0; k < 500; ++k) {
    REQUIRE(hands.lockstep().step());
    least = std::min(least, force_on(hands.lockstep(), 0));
    most = std::max(most, force_on(hands.lockstep(), 0));
  }
  CHECK(least > 3);
  CHECK(most - least < 0.01);
}

TEST_CASE("two hands: what both have given is what the body has", "[pushed][hands]") {
  const double mass = GENERATE(0.02, 0.5);
  const uint32_t late = GENERATE(0u, 10u);  // ticks, both ways
  CAPTURE(mass, late);
  Hands hands(mass, both_press(), {.scene_latency = late, .frame_latency = late});
  Lockstep& lockstep = hands.lockstep();
  double given = 0, most = 0;
  for (int k = 0; k < 700; ++k) {
    REQUIRE(lockstep.step());
    given += kTick * (force_on(lockstep, 0) - force_on(lockstep, 1));
    most = std::max(most, std::fabs(given));
  }
  // sim has not yet used the last ticks
  double unused = 0;
  for (uint32_t hand = 0; hand < 2; ++hand) {
    const ServoFrame& frame = lockstep.frame(hand);
    unused += frame.pushes[0].impulse_W.f.x - seen_of(lockstep.scene(), 0, hand)->impulse_W.f.x;
    CHECK(frame.forgotten_impulse_W == Vec3{});
  }
  const double has = mass * lockstep.scene().objects[0].V_WO.v.x;
  CAPTURE(given, unused, has);
  CHECK(std::fabs(given - unused - has) <= 1e-9 * most);
  CHECK(most > 1e-3);
}

TEST_CASE("two hands: the push of one is felt by the other within two milliseconds",
          "[pushed][hands]") {
  // both press against the box, alike, until all has come to rest
  const HandModel pressing = hand_that(rise(0, 0.05, 0.4));
  Hands hands(0.02, {pressing, pressing});
  Lockstep& lockstep = hands.lockstep();
  for (int k = 0; k < 3000; ++k) REQUIRE(lockstep.step());
  const double first = force_on(lockstep, 0), second = force_on(lockstep, 1);
  REQUIRE(second > 3);
  hands.device(0).move_at(0.3);
  int64_t pushed_ns = 0, felt_ns = 0;
  for (int k = 0; k < 100 && felt_ns == 0; ++k) {
    REQUIRE(lockstep.step());
    if (pushed_ns == 0 && force_on(lockstep, 0) - first > 0.01) pushed_ns = lockstep.frame(0).t_ns;
    if (pushed_ns != 0 && force_on(lockstep, 1) - second > 0.01) felt_ns = lockstep.frame(1).t_ns;
  }
  REQUIRE(pushed_ns > 0);
  REQUIRE(felt_ns > 0);
  CHECK(felt_ns - pushed_ns <= 2'000'000);
}

TEST_CASE("two hands: one servo dies, and the other hand's force goes on", "[pushed][hands]") {
  constexpr double kMass = 0.2;
  Hands hands(kMass, both_press());
  Lockstep& lockstep = hands.lockstep();
  const uint32_t dies = GENERATE(0u, 1u);
  const uint32_t stays = 1 - dies;
  for (int k = 0; k < 600; ++k) REQUIRE(lockstep.step());
  const double pressed = force_on(lockstep, stays);
  REQUIRE(pressed > 3);
  lockstep.stop_servo(dies);
  double last = pressed, largest = 0;
  for (int k = 0; k < 200; ++k) {
    REQUIRE(lockstep.step());
    largest = std::max(largest, std::fabs(force_on(lockstep, stays) - last));
    last = force_on(lockstep, stays);
  }
  // 2 N/ms is the slew of every session
  CHECK(largest < 2);
  lockstep.restart_servo(dies);
  for (int k = 0; k < 100; ++k) REQUIRE(lockstep.step());
  CHECK(lockstep.frame(dies).fault == 0);
  CHECK(lockstep.frame(stays).fault == 0);
}

TEST_CASE("four hands: the same bit for bit on two runs, and each feels the body",
          "[pushed][hands]") {
  const double second_rate = GENERATE(1000.0, 4000.0);
  const auto run = [&] {
    std::vector<HandModel> models(4, hand_that(rise(0, 0.05, 0.4)));
    Hands hands(0.5, std::move(models), {}, second_rate);
    std::array<double, 4> most{};
    for (int k = 0; k < 600; ++k) {
      REQUIRE(hands.lockstep().step());
      for (uint32_t hand = 0; hand < 4; ++hand) {
        most[hand] = std::max(most[hand], force_on(hands.lockstep(), hand));
      }
    }
    for (const double force : most) CHECK(force > 3);
    // the second ticks as often as its rate says
    CHECK(static_cast<double>(hands.lockstep().frame(1).tick) > 0.59 * second_rate);
    return hands.lockstep().hash();
  };
  CHECK(run() == run());
}

namespace {

/// Two balls of 10 mm on springs, whose bases face each other 60 mm apart, far from any object.
struct TwoBalls {
  static constexpr double kRadius = 0.01, kApart = 0.06, kStiff = 3000;
  PushedSession session{0, kStiff};
  std::vector<SessionConfig> plain, configs;
  std::deque<MeshShapeData> owned;
  std::vector<std::vector<MeshShape>> shapes;
  std::vector<ContactShapes> given;
  std::deque<PushingHand> devices;
  std::unique_ptr<Lockstep> lockstep;

  explicit TwoBalls(const std::vector<HandModel>& models) {
    session.config.objects[0].X_WO.p = {0, 0, 1};
    session.config.renderer = find_renderer("virtual-proxy3")->id;
    session.config.proxy_radius = kRadius;
    session.config.coupling.translational_damping = kDamping;
    session.config.n_hands = 2;
    for (uint32_t k = 0; k < 2; ++k) {
      plain.push_back(session.config);
      plain[k].hand = k;
      if (k == 1) plain[k].map.X_WB = {{kApart, 0, 0}, from_rotation_vector({0, 0, M_PI})};
      devices.emplace_back(models[k]);
    }
    std::vector<LockstepHand> hands;
    for (uint32_t k = 0; k < 2; ++k) {
      configs.push_back(with_tools(plain, k));
      shapes.push_back(session.shapes);
      owned.push_back(build_shape(make_mesh(configs[k].objects[1].primitive)));
      shapes[k].push_back(owned.back().view());
    }
    for (uint32_t k = 0; k < 2; ++k) given.emplace_back(shapes[k]);
    for (uint32_t k = 0; k < 2; ++k) hands.push_back({configs[k], given[k], devices[k]});
    lockstep = std::make_unique<Lockstep>(std::span<const LockstepHand>(hands));
  }
};

}  // namespace

TEST_CASE("two hands: their tools meet as two springs in series", "[pushed][hands]") {
  constexpr int kTicks = 3000, kSteps = 50;
  constexpr double kFineStep = 20e-6;
  const std::vector<HandModel> models{hand_that(rise(0, 0.04, 2)), hand_that(rise(0, 0.03, 2))};
  TwoBalls balls(models);
  Lockstep& lockstep = *balls.lockstep;
  std::vector<HandModel> hands = models;
  double squares = 0, most = 0, difference = 0, force = 0;
  for (int k = 0; k < kSteps * kTicks; ++k) {
    const double t = k * kFineStep;
    const double depth = hands[0].x + hands[1].x - (TwoBalls::kApart - 2 * TwoBalls::kRadius);
    const double closing = hands[0].v + hands[1].v;
    force = depth > 0 ? std::max(0.5 * (TwoBalls::kStiff * depth + kDamping * closing), 0.0) : 0;
    if (k % kSteps == 0) {
      REQUIRE(lockstep.step());
      squares += std::pow(force_on(lockstep, 0) - force, 2);
      difference = std::max(difference, std::fabs(force_on(lockstep, 0) - force_on(lockstep, 1)));
      most = std::max(most, force);
    }
    hands[0].step(t, -force, kFineStep);
    // it begins half a tick later, as it ticks
    if (k >= kSteps / 2) hands[1].step(t - kSteps / 2 * kFineStep, -force, kFineStep);
  }
  const double error = std::sqrt(squares / kTicks);
  CAPTURE(error, most, difference, force);
  CHECK(most > 3);
  CHECK(error <= 0.05);
  // at rest both feel the same
  CHECK(force_on(lockstep, 0) == Approx(force).margin(0.02));
  CHECK(force_on(lockstep, 1) == Approx(force).margin(0.02));
  // a hand that feels nothing gives way, and no force steps
  lockstep.control(1).paused = 1;
  double last = force_on(lockstep, 0), largest = 0;
  for (int k = 0; k < 200; ++k) {
    REQUIRE(lockstep.step());
    largest = std::max(largest, std::fabs(force_on(lockstep, 0) - last));
    last = force_on(lockstep, 0);
  }
  CHECK(last == 0);
  CHECK(largest < 2);
}

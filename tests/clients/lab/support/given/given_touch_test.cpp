// SPDX-License-Identifier: GPL-3.0-or-later
// Wrenches and planes of clients, through contact, servo and safety: right ones are felt as the law
// that they are of, and what lies with valid numbers gives the hand no more than it may.
#include <catch2/catch.hpp>
#include <random>

#include "contact/bake/session.h"
#include "proto/wire/renderer.h"
#include "tests/clients/lab/support/pushed_body.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kServoStep = 1e-3;  // [s]

/// What a client gives at a tick of lockstep, by the newest frame of the servo.
using Gives = std::function<void(const ServoFrame& servo, int n, GivenFrame& given)>;

struct Client {
  Gives gives;
  int period = 10;     // between its frames [ticks]
  int late = 1;        // frames that one comes late
  int ends = 1 << 30;  // tick from which on it gives nothing more
};

/// A session with a hand, a client that may push and touch, and a box.
PushedSession session_of(double max_force, double max_power, double mass = 0) {
  PushedSession session(mass, 1500);
  session.config.n_clients = 1;
  ClientConfig& client = session.config.clients[0];
  client.may = kMayPush | kMayTouch;
  client.max_force = max_force;
  client.max_power = max_power;
  return session;
}
/// One without anything to touch but what the client gives.
PushedSession empty_session(double max_force, double max_power) {
  PushedSession session = session_of(max_force, max_power);
  session.config.objects[0].X_WO.p.x = 5;
  return session;
}

struct Felt {
  std::vector<double> force, x;  // held by the device, and where the hand is, at each tick
  std::vector<double> given{0};  // to the hand until then, by force and way [J]
  uint32_t faults = 0;
  double most_in_a_second = -1;  // [J]
  double most_step = 0;          // of the force, beyond slew and the hand's motion [N]
  GiverState giver{};            // at the end

  double most_force() const {
    double most = 0;
    for (const double f : force) most = std::max(most, std::fabs(f));
    return most;
  }
};

Felt feel(PushedSession made, const HandModel& hand, const Client& client, int n_ticks) {
  Pushed pushed(std::move(made), hand);
  Lockstep& lockstep = pushed.lockstep;
  Felt out;
  std::deque<GivenFrame> waiting;
  uint64_t seq = 0;
  for (int n = 0; n < n_ticks; ++n) {
    if (n > 0 && n % client.period == 0 && n < client.ends) {
      GivenFrame frame{};
      frame.seq = ++seq;
      frame.t_ns = lockstep.frame().t_ns;
      client.gives(lockstep.frame(), n, frame);
      waiting.push_back(frame);
      if (waiting.size() > static_cast<size_t>(client.late)) {
        lockstep.give(0, waiting.front());
        waiting.pop_front();
      }
    }
    const double before = pushed.hand.hand().x, last = out.force.empty() ? 0 : out.force.back();
    REQUIRE(lockstep.step());
    out.x.push_back(pushed.hand.hand().x);
    // the force of the tick before was held while the hand moved
    out.given.push_back(out.given.back() + last * (out.x.back() - before));
    out.force.push_back(lockstep.frame().F_device_B.f.x);
    const SafetyConfig& safety = pushed.session.config.safety;
    const double moved = std::fabs(out.x.back() - before);
    const double may = safety.slew * kServoStep + 2 * 1500 * moved + 2;
    out.most_step = std::max(out.most_step, std::fabs(out.force.back() - last) - may);
    out.faults |= lockstep.frame().fault;
    if (n > 1000) {
      const double second = out.given.back() - out.given[out.given.size() - 1001];
      out.most_in_a_second = std::max(out.most_in_a_second, second);
    }
    if (lockstep.contacts() != nullptr && !lockstep.contacts()->givers.empty()) {
      out.giver = lockstep.contacts()->givers[0];
    }
  }
  return out;
}

/// A hand that goes to and fro.
HandModel swinging(double middle, double way, double rate = 3) {
  HandModel hand;
  hand.x = middle - way;
  hand.intent = [=](double t) { return middle - way * std::cos(rate * t); };
  return hand;
}

/// The force of a law on that hand, integrated at 20 µs.
std::vector<double> judged(HandModel hand, const std::function<double(double)>& law, int n_ticks) {
  std::vector<double> force;
  for (int n = 0; n < n_ticks; ++n) {
    force.push_back(law(hand.x));
    for (int i = 0; i < 50; ++i) hand.step(kServoStep * n + 2e-5 * i, law(hand.x), 2e-5);
  }
  return force;
}

/// Root of the mean square of the difference after the client has come.
double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  constexpr size_t kFrom = 300;
  for (size_t n = kFrom; n < a.size(); ++n) sum += (a[n] - b[n]) * (a[n] - b[n]);
  return std::sqrt(sum / static_cast<double>(a.size() - kFrom));
}

void push_with(GivenFrame& given, const ServoFrame& servo, double force, double stiffness = 0,
               double damping = 0, double trust = 0.02) {
  GivenWrench push{};
  push.wrench.X_WT = servo.X_WT;
  push.wrench.F0_W.f.x = force;
  push.wrench.K[0] = stiffness;
  push.wrench.B[0] = damping;
  push.wrench.trust_radius = trust;
  given.pushes.push_back(push);
}

void wall_at(GivenFrame& given, double x, uint32_t object = kNoObject, double extent = 0) {
  GivenPlane plane{};
  plane.object_point_O.x = x;
  plane.normal_O = {-1, 0, 0};
  plane.object = object;
  plane.extent = extent;
  given.planes.push_back(plane);
}

/// A charge at 0.1 m that pulls: 2 N at 5 cm.
double pull(double x) {
  constexpr double kStrength = 5e-3;  // [N·m²]
  return kStrength / ((0.1 - x) * (0.1 - x));
}
double pull_slope(double x) {
  return 2 * pull(x) / (0.1 - x);
}

/// A session of a cube that a client's planes may meet, and nothing else.
constexpr double kCube = 0.01, kSoftPlane = 600, kCubeSpring = 1500;  // [m], [N/m], [N/m]
PushedSession cube_session(Renderer renderer, double max_force) {
  PushedSession session = empty_session(max_force, 20);
  SessionConfig& config = session.config;
  config.renderer = renderer;
  config.coupling.rotational_stiffness = 0.5;
  config.coupling.translational_damping = 1;
  config.proxy.solver = SoftSolver::kQuasiStatic;
  config.proxy.contact_stiffness = kSoftPlane;
  config.tool.primitive = primitive::Box{{kCube, kCube, kCube}};
  config.tool.mass = 0.02;
  config.voxel.offset_layers = 0;
  return session;
}

/// A cube that a hand leads to 20 mm beyond a client's plane; the client ends at that tick.
struct PressedCube {
  double x = 0;           // of the hand at the end [m]
  double force = 0;       // at the end [N]
  double most_force = 0;  // at any tick
};
PressedCube press_cube(Renderer renderer, double max_force, int ends) {
  const PushedSession session = cube_session(renderer, max_force);
  const BakedSession baked = bake_session(session.config);
  const ContactShapes shapes = baked.shapes();
  PushingHand hand({.intent = rise(-0.02, 0.04, 0.5), .x = -0.02});
  Lockstep lockstep(session.config, shapes, hand);
  PressedCube out;
  GivenFrame frame{};
  wall_at(frame, kCube / 2);
  frame.planes[0].tool_point_T.x = kCube / 2;
  for (int n = 0; n < 2500; ++n) {
    frame.t_ns = lockstep.frame().t_ns;
    if (n > 0 && n % 10 == 0 && n < ends) ++frame.seq, lockstep.give(0, frame);
    REQUIRE(lockstep.step());
    out.force = lockstep.frame().F_device_B.f.x;
    out.most_force = std::max(out.most_force, std::fabs(out.force));
  }
  out.x = hand.hand().x;
  return out;
}

}  // namespace

TEST_CASE("given wrench: a charge that pulls is felt as its law, by a client at 100 and 30 Hz") {
  const int period = GENERATE(10, 33);
  const HandModel hand = swinging(0.02, 0.03);
  const Gives charge = [](const ServoFrame& servo, int, GivenFrame& given) {
    push_with(given, servo, pull(servo.X_WT.p.x), pull_slope(servo.X_WT.p.x));
  };
  const Gives without_slope = [](const ServoFrame& servo, int, GivenFrame& given) {
    push_with(given, servo, pull(servo.X_WT.p.x));
  };
  const auto law = judged(hand, pull, 4000);
  const double right = rms(feel(empty_session(20, 20), hand, {charge, period}, 4000).force, law);
  const double coarse =
      rms(feel(empty_session(20, 20), hand, {without_slope, period}, 4000).force, law);
  CAPTURE(period, right, coarse);
  CHECK(right <= 0.05);
  CHECK(coarse > 2 * right);
}

TEST_CASE(
    "given wrench: a stiff spring gives the hand nothing if it states its K, and is cut if "
    "not") {
  const HandModel hand = swinging(0.01, 0.02, 5);
  const Gives spring = [](const ServoFrame& servo, int, GivenFrame& given) {
    const double x = servo.X_WT.p.x;
    push_with(given, servo, -800 * x, -800, 0, 1);
  };
  const Gives blind = [](const ServoFrame& servo, int, GivenFrame& given) {
    push_with(given, servo, -800 * servo.X_WT.p.x);
  };
  const HandModel still = {.x = 2e-3};
  Client client{spring, 33};
  const Felt right = feel(empty_session(50, 20), still, client, 20'000);
  const auto law = judged(
      still, [](double x) { return -800 * x; }, 20'000);
  CAPTURE(rms(right.force, law), right.given.back());
  CHECK(rms(right.force, law) <= 0.05);
  client.gives = blind;
  const Felt cycles = feel(empty_session(50, 20), still, client, 5000);
  const Felt bounded = feel(empty_session(50, 0.2), still, client, 5000);
  CAPTURE(cycles.most_force(), cycles.most_in_a_second, bounded.most_in_a_second);
  CHECK(cycles.most_in_a_second > 0.2);
  CHECK(bounded.most_in_a_second <= 0.2);
  CHECK((bounded.giver.flags & kGiverCut) != 0);
}

TEST_CASE("given plane: a wall in the world is as stiff as the coupling, and ends at its extent") {
  const HandModel hand = {.intent = rise(-0.02, 0.04, 0.5), .x = -0.02};
  const Gives wall = [](const ServoFrame&, int, GivenFrame& given) { wall_at(given, 0); };
  const Felt felt = feel(empty_session(20, 1), hand, {wall}, 2000);
  const double depth = felt.x.back();
  REQUIRE(depth > 1e-3);
  CHECK(felt.force.back() == Approx(-1500 * depth).epsilon(1e-6));
  // the hand is pushed by its spring of 300 N/m to 20 mm
  CHECK(depth == Approx(300 * 0.02 / 1800).epsilon(0.01));
  const Gives aside = [](const ServoFrame&, int, GivenFrame& given) {
    wall_at(given, 0, kNoObject, 0.01);
    given.planes[0].object_point_O.y = 0.02;
  };
  CHECK(feel(empty_session(20, 1), hand, {aside}, 2000).most_force() == 0);
}

TEST_CASE("given plane: a tool with six degrees of freedom meets it with its coupling in series") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6,
                                     Renderer::kDirect6, Renderer::kVoxel, Renderer::kLocalized);
  const PressedCube cube = press_cube(renderer, 50, 2500);
  const bool is_rigid = row_of(renderer).moves == Moves::kRigidBody;
  const double in_series = 1 / (1 / kCubeSpring + 1 / kSoftPlane);
  const double stiffness = is_rigid ? kCubeSpring : in_series;
  CAPTURE(row_of(renderer).name, cube.x);
  CHECK(cube.force == Approx(-stiffness * cube.x).epsilon(0.02));
  CHECK(cube.x == Approx(300 * 0.02 / (300 + stiffness)).epsilon(0.02));
}

TEST_CASE(
    "given plane: a tool with six degrees of freedom feels no more than max_force of it, also "
    "when its client ends") {
  const Renderer renderer =
      GENERATE(Renderer::kGodObject6, Renderer::kConstrained6, Renderer::kVoxel);
  const PressedCube cube = press_cube(renderer, 2, 1500);
  CAPTURE(row_of(renderer).name);
  // what damps and brakes the tool beside the plane is no part of it
  CHECK(cube.most_force <= 2.1);
  CHECK(cube.most_force >= 1.9);
  CHECK(std::fabs(cube.force) < 0.01);
}

TEST_CASE("given plane: what the hand gives by planes on a body is what the body has") {
  HandModel hand;
  hand.x = -0.02;
  hand.intent = [](double t) { return rise(-0.02, 0.06, 0.5)(t - 0.4); };
  Pushed pushed(session_of(50, 20, 0.1), hand);
  Lockstep& lockstep = pushed.lockstep;
  double given = 0, touched_at = 0;
  for (int n = 0; n < 1500; ++n) {
    if (n % 10 == 5) {
      GivenFrame frame{};
      frame.seq = static_cast<uint64_t>(n) + 1;
      frame.t_ns = lockstep.frame().t_ns;
      // 5 mm before the face of the box
      wall_at(frame, -kBoxEdge / 2 - 5e-3, 0);
      lockstep.give(0, frame);
    }
    REQUIRE(lockstep.step());
    given -= kServoStep * lockstep.frame().F_coupling_W.f.x;
    if (touched_at == 0 && given != 0) touched_at = lockstep.frame().X_WT.p.x;
  }
  CHECK(touched_at == Approx(kFace - 5e-3).margin(1e-3));
  check_balance(lockstep, 0.1, given);
}

TEST_CASE("given touch: the hand feels a fade where the client dies, and nothing of who may not") {
  const HandModel hand = {.intent = rise(-0.02, 0.04, 0.5), .x = -0.02};
  const bool by_planes = GENERATE(false, true);
  const Gives gives = [=](const ServoFrame& servo, int, GivenFrame& given) {
    by_planes ? wall_at(given, 0) : push_with(given, servo, -3);
  };
  Client client{gives};
  client.ends = 1500;
  const Felt felt = feel(empty_session(20, 1), hand, client, 2000);
  CAPTURE(by_planes);
  CHECK(std::fabs(felt.force[1499]) > 2);
  // its last frame came at 1490; three periods later it fades within 50 ms
  CHECK(felt.force[1515] == Approx(felt.force[1499]).epsilon(0.02));
  CHECK(std::fabs(felt.force[1545]) < 0.8 * std::fabs(felt.force[1515]));
  CHECK(felt.force[1600] == 0);
  CHECK((felt.giver.flags & kGiverLate) != 0);
  PushedSession forbidden = empty_session(20, 1);
  forbidden.config.clients[0].may = by_planes ? kMayPush : kMayTouch;
  const Felt none = feel(std::move(forbidden), hand, {gives}, 2000);
  CHECK(none.most_force() == 0);
  CHECK(none.giver.refusal == static_cast<uint32_t>(GiverRefusal::kNotAllowed));
}

TEST_CASE("given touch: who lies with valid numbers gives the hand no more than max_power") {
  // 10⁴ ticks of each in a normal run; HAPTIC_TORTURE_SCALE=100 gives 10⁶
  const int n_ticks = static_cast<int>(10'000 * torture_scale());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  struct Named {
    const char* name;
    Gives gives;
  };
  const auto along = [](const ServoFrame& servo) { return servo.V_WT.v.x < 0 ? -1.0 : 1.0; };
  const std::vector<Named> all{
      {"a wrench in phase with the velocity",
       [&](const ServoFrame& servo, int, GivenFrame& g) {
         push_with(g, servo, 20 * along(servo));
       }},
      {"a B that drives",
       [&](const ServoFrame& servo, int, GivenFrame& g) { push_with(g, servo, 0, 0, -50); }},
      {"a K as stiff as 10⁶ N/m that pushes away",
       [&](const ServoFrame& servo, int, GivenFrame& g) { push_with(g, servo, 0, 1e6); }},
      {"wrenches at random",
       [&](const ServoFrame& servo, int, GivenFrame& g) {
         push_with(g, servo, 1e5 * uniform(random), 1e4 * uniform(random), uniform(random), 10);
       }},
      {"planes that close on the tool",
       [&](const ServoFrame& servo, int n, GivenFrame& g) {
         const double by = 1e-4 * (n % 500);
         wall_at(g, servo.X_WT.p.x - by);
         GivenPlane other = g.planes[0];
         other.object_point_O.x = servo.X_WT.p.x + by;
         other.normal_O.x = 1;
         g.planes.push_back(other);
       }},
      {"planes that drive the hand on",
       [&](const ServoFrame& servo, int, GivenFrame& g) {
         wall_at(g, servo.X_WT.p.x + 5e-3 * along(servo));
         g.planes[0].normal_O.x = along(servo);
       }},
      {"planes at random", [&](const ServoFrame& servo, int, GivenFrame& g) {
         for (int i = 0; i < 24; ++i) {
           wall_at(g, servo.X_WT.p.x + 5e-3 * uniform(random), i % 2 == 0 ? kNoObject : 0);
           g.planes.back().normal_O.x = uniform(random) < 0 ? -1 : 1;
         }
       }}};
  for (const Named& one : all) {
    PushedSession session = empty_session(2, 0.2);
    session.config.safety = {};
    session.config.safety.max_force = 6;
    const Felt result = feel(std::move(session), swinging(0, 0.03, 9), {one.gives}, n_ticks);
    CAPTURE(one.name, result.most_in_a_second, result.most_force(), result.most_step);
    CHECK(result.most_in_a_second <= 0.2);
    CHECK(result.most_step <= 0);
    CHECK(result.most_force() <= 2.01);
    CHECK(result.faults == 0);
  }
}

// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes with mechanisms, played in lockstep by the hand of their demo.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "clients/lockstep/lockstep.h"
#include "contact/bake/session.h"
#include "device-io/device.h"
#include "proto/math/units.h"
#include "proto/wire/scene_pose.h"
#include "tests/sim/energy_judge.h"
#include "tests/support/data.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using haptic::test::EnergyJudge;
using haptic::test::JudgedBody;

namespace {

/// A shipped scene with its hand.
struct Demo {
  explicit Demo(const std::string& name, double sim_rate = 0)
      : config(load_config(test::from_source("configs/" + name + ".toml"))),
        baked(bake_session(at_rate(config, sim_rate))),
        hand(open_device(config.device)),
        lockstep(config, baked.shapes(), *hand) {}

  /// Plays for so many seconds, or until the hand has ended; `look` is called after each tick.
  void play(double seconds, const std::function<void()>& look) {
    for (int k = 0; 1e-3 * k < seconds && lockstep.step(); ++k) {
      const double force = norm(lockstep.frame().F_device_B.f);
      REQUIRE(force <= config.safety.max_force * (1 + 1e-9));
      most_force = std::max(most_force, force);
      look();
      if ((lockstep.frame().device.flags & kDeviceEnded) != 0) break;
    }
  }
  /// The config itself, with another rate of sim; zero: its own.
  static const SessionConfig& at_rate(SessionConfig& config, double sim_rate) {
    if (sim_rate > 0) config.sim_rate = sim_rate;
    return config;
  }
  const JointState& joint(size_t i) const { return lockstep.scene().joints[i]; }

  SessionConfig config;
  BakedSession baked;
  std::unique_ptr<Device> hand;
  Lockstep lockstep;
  double most_force = 0;
};

/// Mass, centre and inertia of a closed mesh of uniform density, by the tetrahedra that its
/// triangles make with the origin. Its mass is given, or follows from the density.
JudgedBody judged_mesh(uint32_t object, const TriangleMesh& mesh, const BodyConfig& config) {
  double volume = 0;
  Vec3 moment;
  std::array<std::array<double, 3>, 3> second{};
  for (const Triangle& t : mesh.triangles) {
    const std::array corners{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    const double v = dot(corners[0], cross(corners[1], corners[2])) / 6;
    const Vec3 sum = corners[0] + corners[1] + corners[2];
    volume += v;
    moment += v / 4 * sum;
    for (size_t i = 0; i < 3; ++i) {
      for (size_t k = 0; k < 3; ++k) {
        const int a = static_cast<int>(i), b = static_cast<int>(k);
        double products = sum[a] * sum[b];
        for (const Vec3& c : corners) products += c[a] * c[b];
        second[i][k] += v / 20 * products;
      }
    }
  }
  const double mass = config.mass > 0 ? config.mass : config.density * volume;
  const double density = mass / volume;
  JudgedBody body{object, mass, 1 / volume * moment, {}};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      const int a = static_cast<int>(i), b = static_cast<int>(k);
      second[i][k] = density * second[i][k] - mass * body.centre_O[a] * body.centre_O[b];
    }
  }
  const double trace = second[0][0] + second[1][1] + second[2][2];
  for (int i = 0; i < 3; ++i) {
    const auto& row = second[static_cast<size_t>(i)];
    body.inertia_O.row[i] = trace * Mat3{}.row[i] - Vec3{row[0], row[1], row[2]};
  }
  return body;
}

/// The energy that spring and detents of a joint store at q [J]; the detents' table is taken as
/// straight lines.
double stored_in(const JointConfig& joint, double q) {
  double sum = 0.5 * joint.stiffness * (q - joint.rest) * (q - joint.rest);
  for (uint32_t i = 0; i + 1 < joint.n_detents; ++i) {
    const auto& [q0, f0] = joint.detents[i];
    const auto& [q1, f1] = joint.detents[i + 1];
    const double end = std::clamp(q, q0, q1), s = (end - q0) / (q1 - q0);
    sum -= (end - q0) * (f0 + 0.5 * s * (f1 - f0));
  }
  return sum;
}

/// The distance of the pin of gearshift from neutral, which is 1.5 mm to either side, and from both
/// lanes, which are 0.5 mm to either side [m].
double outside_of_lanes(double x, double z) {
  return std::min(std::fabs(z) - 1.5e-3, std::fabs(std::fabs(x) - 25e-3) - 0.5e-3);
}

}  // namespace

TEST_CASE("scene door: opened over both detents and shut into its latch", "[mechanisms]") {
  Demo door("door");
  double widest = 0;
  int open_at_35 = 0, open_at_50 = 0;
  door.play(20, [&] {
    const double q = door.joint(0).position;
    REQUIRE(q >= -1e-9);
    REQUIRE(q <= 72 * kDegree + 1e-9);
    widest = std::max(widest, q);
    if (q > 33 * kDegree && q < 37 * kDegree) ++open_at_35;
    if (q > 48 * kDegree && q < 52 * kDegree) ++open_at_50;
  });
  CAPTURE(widest / kDegree, open_at_35, open_at_50, door.most_force);
  CHECK(widest > 68 * kDegree);
  // the check holds it there for a while
  CHECK(open_at_35 > 2 * open_at_50);
  CHECK(std::fabs(door.joint(0).position) < 0.1 * kDegree);
  CHECK(door.most_force > 2.5);
}

TEST_CASE("scene gear-pair: the turned gear turns the other by the ratio of teeth",
          "[mechanisms]") {
  Demo gears("gear-pair");
  // each tooth is thinner by 0.1 mm along the pitch circle
  constexpr double kBacklash = 2 * 0.1e-3;
  constexpr double kSmall = 30e-3, kLarge = 45e-3;  // radii of the pitch circles [m]
  double most = 0, least = 0, off = 0;
  gears.play(3.3, [&] {
    const double small = gears.joint(0).position, large = gears.joint(1).position;
    most = std::max(most, small);
    least = std::min(least, small);
    // rolled off on the two circles, in opposite directions
    off = std::max(off, std::fabs(kSmall * small + kLarge * large));
  });
  CAPTURE(most, least, off, gears.most_force);
  CHECK(most - least > 60 * kDegree);
  CHECK(off <= kBacklash);
}

TEST_CASE("scene gearshift: two gears and a third, and never through a wall", "[mechanisms]") {
  Demo shift("gearshift");
  std::vector<int> gears;
  double outside = 0;
  shift.play(20, [&] {
    const double x = shift.joint(1).position, z = shift.joint(2).position;
    outside = std::max(outside, outside_of_lanes(x, z));
    if (std::fabs(z) < 28e-3) return;
    const int gear = (x < 0 ? 1 : 3) + (z < 0 ? 0 : 1);
    if (gears.empty() || gears.back() != gear) gears.push_back(gear);
  });
  CHECK(gears == std::vector<int>{1, 2, 3});
  CAPTURE(outside);
  CHECK(outside < 0.5e-3);
}

TEST_CASE("scene gearshift: no gear is reached through a wall", "[mechanisms]") {
  // a hand's strength, and more: at 2 m/s a step is 2 mm, which a wall takes back
  const auto [strength, depth] = GENERATE(std::pair(5.0, 1e-3), std::pair(20.0, 4e-3));
  const Demo shift("gearshift");
  const ContactShapes shapes = shift.baked.shapes();
  const SimModel model = build_sim(shift.config, shapes.objects, shapes.collision_pieces);
  const uint32_t pin = shift.config.joints[2].object;
  SimState state;
  ServoFrame hand{};
  hand.t_ns = hand.impulses_since_ns = 1'000'000'000;
  SceneFrame scene = sim_step(model, state, {&hand}, hand.t_ns);
  hand.pushes.resize(scene.responses.size());
  auto& [J, S] = hand.pushes[scene.objects[pin].response];
  double outside = 0, most_x = 0, most_z = 0;
  for (int way = 0; way < 40; ++way) {
    // directions that no lane has, in an order that visits neutral and gears
    const double a = 2 * std::numbers::pi * 0.6180339887 * way;
    const Vec3 force_W = strength * Vec3{std::cos(a), 0, std::sin(a)};
    for (int k = 0; k < 120; ++k) {
      S = S + 1e-3 * J + Wrench{5e-7 * force_W, {}};
      J.f += 1e-3 * force_W;
      hand.t_ns += 1'000'000;
      scene = sim_step(model, state, {&hand}, hand.t_ns);
      const double x = std::fabs(scene.joints[1].position);
      const double z = std::fabs(scene.joints[2].position);
      outside = std::max({outside, outside_of_lanes(x, z), x - 25.5e-3, z - 35.5e-3});
      most_x = std::max(most_x, x);
      most_z = std::max(most_z, z);
    }
  }
  CAPTURE(strength, outside, most_x, most_z);
  CHECK(outside < depth);
  CHECK(most_x > 24e-3);
  if (strength > 10) CHECK(most_z > 28e-3);
}

TEST_CASE("scene heap: what the hand pushes falls, and nothing falls for ever", "[mechanisms]") {
  Demo heap("heap");
  heap.play(15, [] {});
  const SceneFrame& scene = heap.lockstep.scene();
  int moved = 0;
  for (uint32_t i = 2; i < heap.config.n_objects; ++i) {
    const Vec3& p = scene.objects[i].X_WO.p;
    CAPTURE(i, p.x, p.y, p.z);
    moved += norm(p - heap.config.objects[i].X_WO.p) > 0.01 ? 1 : 0;
    // nothing sinks into the table; what has fallen may slide below it
    const bool over_table = std::fabs(p.x) < 0.18 && std::fabs(p.z) < 0.12;
    if (over_table) CHECK((p.y > 4e-3 || p.y < -0.02 - 4e-3));
    const bool over_ground = std::fabs(p.x) < 0.35 && std::fabs(p.z) < 0.3;
    if (over_ground) CHECK(p.y > -0.16 + 4e-3);
    // a tin may roll off the ground as well
    CHECK(norm(p - heap.config.objects[i].X_WO.p) < heap.config.sim_reach + 0.01);
  }
  CHECK(moved >= 3);
  // the upper box has come down
  CHECK(scene.objects[7].X_WO.p.y < 0.06);
}

TEST_CASE("bodies: a ring falls over a post, since it collides as its convex pieces",
          "[mechanisms]") {
  const SessionConfig config = parse_config(
      "[session]\nname = \"ring\"\n[device]\nkind = \"simulated-hand\"\n"
      "[sim]\ngravity = [\"0 m/s²\", \"0 m/s²\", \"-9.81 m/s²\"]\n"
      "[[object]]\nname = \"ground\"\nprimitive = \"box\"\n"
      "extent = [\"100 mm\", \"100 mm\", \"10 mm\"]\nposition = [\"0 mm\", \"0 mm\", \"-5 mm\"]\n"
      "[[object]]\nname = \"post\"\nprimitive = \"peg\"\ndiameter = \"20 mm\"\nlength = \"40 mm\"\n"
      "around = 24\nalong = 1\nposition = [\"0 mm\", \"0 mm\", \"20 mm\"]\n"
      "[[object]]\nname = \"ring\"\nprimitive = \"hole\"\ndiameter = \"20 mm\"\n"
      "clearance = \"1 mm\"\nlength = \"10 mm\"\nblock = \"40 mm\"\naround = 24\nalong = 1\n"
      "position = [\"0.5 mm\", \"0 mm\", \"60 mm\"]\n[object.body]\nmass = \"50 g\"\n",
      "ring.toml");
  const BakedSession baked = bake_session(config);
  const ContactShapes shapes = baked.shapes();
  const bool has_pieces = GENERATE(true, false);
  std::span<const PieceTree> pieces = shapes.collision_pieces;
  if (!has_pieces) pieces = {};
  const SimModel model = build_sim(config, shapes.objects, pieces);
  SimState state;
  SceneFrame scene{};
  for (int64_t k = 0; k <= 400; ++k) scene = sim_step(model, state, 1'000'000'000 + k * 1'000'000);
  // without them it is its hull, and lies on the post
  CHECK(scene.objects[2].X_WO.p.z == Approx(has_pieces ? 5e-3 : 45e-3).margin(0.2e-3));
}

TEST_CASE("scenes with bodies: they have no more energy than the hand gives them",
          "[mechanisms][energy]") {
  const std::string name = GENERATE("carry", "door", "gear-pair", "gearshift", "heap");
  const double rate = GENERATE(200.0, 1000.0);
  Demo demo(name, rate);
  const ContactShapes shapes = demo.baked.shapes();
  std::vector<JudgedBody> bodies;
  for (uint32_t i = 0; i < demo.config.n_objects; ++i) {
    const BodyConfig& body = demo.config.objects[i].body;
    if (has_mass(body)) bodies.push_back(judged_mesh(i, shapes.objects[i].mesh, body));
  }
  EnergyJudge judge(bodies, demo.config.gravity_W, rate);
  judge.add_store([&](const SceneFrame& frame) {
    double sum = 0;
    for (uint32_t j = 0; j < demo.config.n_joints; ++j) {
      sum += stored_in(demo.config.joints[j], frame.joints[j].position);
    }
    return sum;
  });
  // what sim has taken of the hand's impulses as a mean force, along the way of the poses
  double given = 0;
  SceneFrame last{};
  const auto look = [&] {
    const SceneFrame& scene = demo.lockstep.scene();
    if (scene.seq == last.seq) return;
    if (last.seq == 0) {
      judge.begin(scene);
      last = scene;
      return;
    }
    const double dt = 1e-9 * static_cast<double>(scene.t_ns - last.t_ns);
    for (const JudgedBody& body : bodies) {
      const uint32_t i = body.object;
      const Wrench J = seen_of(scene, i, 0)->impulse_W + -seen_of(last, i, 0)->impulse_W;
      const Twist way = way_between(last.objects[i].X_WO, scene.objects[i].X_WO);
      given += 1 / dt * (dot(J.f, way.v) + dot(J.t, way.w));
    }
    judge.add(scene, given);
    last = scene;
  };
  demo.play(static_cast<double>(test::sweep(30)), look);
  CAPTURE(name, rate, judge.excess(), judge.largest_kinetic(), given, judge.start(),
          judge.last_mean());
  CHECK(judge.excess() <= 1e-12);
}

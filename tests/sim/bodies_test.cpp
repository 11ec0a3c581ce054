// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/bodies.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "contact/shape/parts/machine_parts.h"
#include "proto/config/out_of_reach.h"
#include "proto/wire/scene_pose.h"
#include "tests/sim/body_scene.h"
#include "tests/support/frames.h"
#include "tests/support/near.h"

using namespace haptic;
using haptic::test::BodyScene;
using haptic::test::BodySim;
using haptic::test::IsNear;
using haptic::test::kGravity;
using haptic::test::tol;

namespace {

constexpr double kEdge = 0.02;  // of a box [m]

Vec3 edges(double edge) {
  return {edge, edge, edge};
}

BodyScene scene_with_ground() {
  BodyScene scene;
  scene.config.gravity_W = {0, 0, -kGravity};
  scene.add_box({0.4, 0.4, 0.02}, {{0, 0, -0.01}, {}}, 0).material.friction_dynamic = 0.6;
  return scene;
}

/// Kinetic energy and that of the height over z = 0 [J], by the frame alone.
double energy_of(const BodyScene& scene, const SceneFrame& frame) {
  double energy = 0;
  for (uint32_t i = 0; i < frame.objects.size(); ++i) {
    const double m = scene.config.objects[i].body.mass;
    if (m == 0) continue;
    const Vec3 d = scene.shapes[i].mesh.upper - scene.shapes[i].mesh.lower;
    const Vec3 w_O = rotate(conjugate(frame.objects[i].X_WO.q), frame.objects[i].V_WO.w);
    const Vec3 I =
        (m / 12) * Vec3{d.y * d.y + d.z * d.z, d.z * d.z + d.x * d.x, d.x * d.x + d.y * d.y};
    energy += 0.5 * m * norm_squared(frame.objects[i].V_WO.v) -
              m * dot(scene.config.gravity_W, frame.objects[i].X_WO.p);
    energy += 0.5 * (I.x * w_O.x * w_O.x + I.y * w_O.y * w_O.y + I.z * w_O.z * w_O.z);
  }
  return energy;
}

}  // namespace

TEST_CASE("bodies: a body that falls is where the closed form puts it", "[sim][bodies]") {
  BodyScene scene;
  scene.config.gravity_W = {0, 1, -kGravity};
  scene.add_box(edges(kEdge), {{0.1, 0, 0.5}, {}}, 0.01);
  BodySim sim(scene);
  for (int k = 1; k <= 250; ++k) {
    sim.step();
    const double t = 1e-3 * k;
    REQUIRE_THAT(sim.frame.objects[0].X_WO.p,
                 IsNear(Vec3{0.1, 0, 0.5} + 0.5 * t * t * scene.config.gravity_W, 1e-12));
    REQUIRE_THAT(sim.frame.objects[0].V_WO.v, IsNear(t * scene.config.gravity_W, 1e-12));
  }
}

TEST_CASE("bodies: the mobility of a free body is its mass and inertia", "[sim][bodies]") {
  BodyScene scene;
  scene.add_box({0.01, 0.02, 0.03}, {{}, from_rotation_vector({0.3, -1, 0.2})}, 0.06);
  BodySim sim(scene);
  const ObjectResponse& response = sim.step().responses[0];
  // by the formula for a box, for an impulse through a corner
  const Wrench J_W{{0.01, -0.02, 0.005}, {1e-4, 0, -2e-4}};
  const Quat q = sim.frame.objects[0].X_WO.q;
  const Vec3 t_O = rotate(conjugate(q), J_W.t);
  const Vec3 I{0.06 / 12 * (4e-4 + 9e-4), 0.06 / 12 * (9e-4 + 1e-4), 0.06 / 12 * (1e-4 + 4e-4)};
  const Twist moved = moved_by(response.mobility, J_W);
  CHECK_THAT(moved.v, IsNear((1 / 0.06) * J_W.f, 1e-12));
  CHECK_THAT(moved.w, IsNear(rotate(q, {t_O.x / I.x, t_O.y / I.y, t_O.z / I.z}), 1e-9));
}

TEST_CASE("bodies: ten boxes of 20 mm stand for a minute and are asleep at the end",
          "[sim][bodies]") {
  BodyScene scene = scene_with_ground();
  for (int k = 0; k < 10; ++k) {
    scene.add_box(edges(kEdge), {{0, 0, kEdge * (0.5 + k)}, {}}, 0.01).material.friction_dynamic =
        0.6;
  }
  BodySim sim(scene);
  for (int k = 0; k < 60'000; ++k) sim.step();
  for (uint32_t i = 1; i <= 10; ++i) {
    CAPTURE(i);
    CHECK_THAT(sim.frame.objects[i].X_WO.p, IsNear(scene.config.objects[i].X_WO.p, 1e-3));
    CHECK(sim.state.bodies.world->motion(i).asleep);
    CHECK(sim.frame.objects[i].V_WO == Twist{});
  }
}

TEST_CASE("bodies: a sim that has left out ticks catches up, where its step leaves it time to",
          "[sim][bodies]") {
  constexpr double kRested = 5.0 / 3;  // of what it was busy: when it may begin again (sim/main)
  const double share = GENERATE(0.1, 0.31, 0.45, 0.59);  // of a period, that one step takes
  for (int late = 1; late <= 20; ++late) {
    CAPTURE(share, late);
    int ticks = late;  // since the frame before
    for (int k = 0; k < 20; ++k) {
      const int steps = steps_between(1e-3 * ticks, 1e-3);
      REQUIRE(steps >= 1);
      REQUIRE(1e-3 * ticks / steps < 2.5e-3);
      ticks = std::max(1, static_cast<int>(std::ceil(kRested * share * steps)));
    }
    CHECK(ticks == 1);
  }
}

TEST_CASE("bodies: a stack stands whatever ticks are left out", "[sim][bodies]") {
  BodyScene scene = scene_with_ground();
  for (int k = 0; k < 6; ++k) {
    scene.add_box(edges(kEdge), {{0, 0, kEdge * (0.5 + k)}, {}}, 0.01).material.friction_dynamic =
        0.6;
  }
  BodySim sim(scene);
  std::mt19937 random(GENERATE(1u, 2u, 3u));
  std::uniform_int_distribution<int> periods(1, 8);
  for (int k = 0; k < 5'000; ++k) {
    sim.period_ns = periods(random) * 1'000'000;
    sim.step();
  }
  for (uint32_t i = 1; i <= 6; ++i) {
    CAPTURE(i);
    CHECK_THAT(sim.frame.objects[i].X_WO.p, IsNear(scene.config.objects[i].X_WO.p, 1e-3));
  }
}

TEST_CASE("bodies: a peg dropped upright into its hole falls to the ground", "[sim][bodies]") {
  primitive::Hole pair{{.grid = {24, 2}}};
  pair.clearance = 0.5e-3;
  BodyScene scene = scene_with_ground();
  const double half = 0.5 * pair.length;
  scene.add(make_hole(pair), {{0, 0, half}, {}}, 0).material.friction_dynamic = 0.3;
  scene.add(make_peg(pair), {{0, 0, 3 * half + 0.01}, {}}, 0.05).material.friction_dynamic = 0.3;
  BodySim sim(scene);
  for (int k = 0; k < 700; ++k) sim.step();
  CHECK(sim.frame.objects[2].X_WO.p.z == Approx(half).margin(0.1e-3));
  CHECK(std::hypot(sim.frame.objects[2].X_WO.p.x, sim.frame.objects[2].X_WO.p.y) < pair.clearance);
}

TEST_CASE("bodies: the energy of bodies that nobody pushes never exceeds its start",
          "[sim][bodies]") {
  BodyScene scene = scene_with_ground();
  const double restitution = GENERATE(0.0, 0.8);
  for (int k = 0; k < 6; ++k) {
    const Quat q = from_rotation_vector({0.3 * k, -0.2, 0.5 * k});
    ObjectConfig& box =
        scene.add_box({0.01 + 0.002 * k, 0.02, 0.015},
                      {{0.012 * (k % 3), 0.004 * k, 0.05 + 0.03 * k}, q}, 0.005 * (k + 1));
    box.material.friction_dynamic = 0.4;
    box.body.restitution = restitution;
  }
  scene.config.objects[0].body.restitution = restitution;
  BodySim sim(scene);
  const double start = energy_of(scene, sim.frame);
  double most = 0;
  for (int k = 0; k < 3'000; ++k) most = std::max(most, energy_of(scene, sim.step()));
  CAPTURE(start, most);
  CHECK(most <= 1.001 * start + 10e-6);
  // they have come down
  CHECK(energy_of(scene, sim.frame) < 0.5 * start);
}

TEST_CASE("bodies: a body that turns freely gains no energy", "[sim][bodies]") {
  BodyScene scene;
  scene.add_box({0.01, 0.02, 0.04}, {}, 0.02);
  SimModel model = build_sim(scene.config, scene.shapes);
  SimState state;
  SceneFrame last{};
  // about the axis that is not stable
  last.objects.push_back(test::scene_object({}, {{0.1, 0, 0}, {0.2, 12, 0.3}}));
  test::add_response(last, 0);
  test::set_time(last, 1'000'000'000);
  resume(model, state, last);
  SceneFrame frame = sim_step(model, state, last.t_ns);
  const double start = energy_of(scene, frame);
  for (int64_t k = 1; k <= 3'000; ++k) {
    frame = sim_step(model, state, last.t_ns + k * 1'000'000);
    REQUIRE(energy_of(scene, frame) <= 1.001 * start + 10e-6);
  }
}

TEST_CASE("bodies: a wall takes the mobility across it, a corner all of it", "[sim][bodies]") {
  BodyScene scene;
  constexpr double kMass = 0.005;
  scene.add_box(edges(kEdge), {}, kMass);
  scene.add_box({kEdge, 0.1, 0.1}, {{kEdge, 0, 0}, {}}, 0);
  const bool has_corner = GENERATE(false, true);
  if (has_corner) {
    scene.add_box({0.1, kEdge, 0.1}, {{0, kEdge, 0}, {}}, 0);
    scene.add_box({0.1, 0.1, kEdge}, {{0, 0, kEdge}, {}}, 0);
  }
  BodySim sim(scene);
  ServoFrame hand{};
  hand.t_ns = hand.impulses_since_ns = sim.t_ns;
  hand.pushes.resize(1);
  ObjectPush& pushed = hand.pushes[0];
  for (int k = 0; k < 20; ++k) {
    hand.t_ns += 1'000'000;
    pushed.impulse_time_W = pushed.impulse_time_W + 1e-3 * pushed.impulse_W;
    pushed.impulse_W.f += Vec3{1e-3, has_corner ? 1e-3 : 0, has_corner ? 1e-3 : 0};
    sim.step(&hand);
  }
  CHECK_THAT(sim.frame.objects[0].X_WO.p, IsNear({}, 50e-6));
  const auto& mobility = sim.frame.responses[0].mobility;
  if (has_corner) {
    CHECK(*std::max_element(mobility.begin(), mobility.end()) < 1e-3 / kMass);
    return;
  }
  CHECK(mobility[0] < 1e-3 / kMass);
  CHECK(mobility[7] == Approx(1 / kMass).epsilon(1e-3));
  CHECK(mobility[14] == Approx(1 / kMass).epsilon(1e-3));
}

TEST_CASE("bodies: two runs are the same bit for bit", "[sim][bodies]") {
  BodyScene scene = scene_with_ground();
  for (int k = 0; k < 8; ++k) {
    scene.add_box(edges(kEdge), {{0.003 * k, -0.002 * k, 0.02 + 0.025 * k}, {}}, 0.01)
        .material.friction_dynamic = 0.3;
  }
  BodySim one(scene), other(scene);
  for (int k = 0; k < 600; ++k) {
    one.step();
    other.step();
    REQUIRE(test::bytes_in_use(one.frame) == test::bytes_in_use(other.frame));
  }
}

TEST_CASE("bodies: a restarted sim goes on where readers have carried the body", "[sim][bodies]") {
  BodyScene scene;
  scene.config.gravity_W = {0, 0, -kGravity};
  scene.add_box(edges(kEdge), {{0, 0, 1}, {}}, 0.02);
  BodySim first(scene);
  ServoFrame hand{};
  hand.t_ns = hand.impulses_since_ns = first.t_ns;
  hand.pushes.resize(1);
  ObjectPush& pushed = hand.pushes[0];
  const auto push = [&](const Vec3& impulse_W) {
    pushed.impulse_time_W = pushed.impulse_time_W + 1e-3 * pushed.impulse_W;
    hand.t_ns += 1'000'000;
    pushed.impulse_W.f += impulse_W;
  };
  for (int k = 0; k < 50; ++k) {
    push({1e-3, 0, 0});
    first.step(&hand);
  }
  const SceneFrame last = first.frame;
  // what is pushed after the last frame is seen by nobody
  push({2e-3, 0, 0});
  const int64_t outage_ns = GENERATE(5, 200) * int64_t{1'000'000};
  pushed.impulse_time_W =
      pushed.impulse_time_W + seconds_of(outage_ns - 1'000'000) * pushed.impulse_W;
  hand.t_ns = last.t_ns + outage_ns;
  SimState second;
  resume(first.model, second, last);
  const SceneFrame next = sim_step(first.model, second, {&hand}, hand.t_ns);
  CHECK(next.seq == last.seq + 1);
  CHECK_THAT(next.objects[0].X_WO.p,
             IsNear(object_pose_at(last, 0, hand.t_ns, push_of(hand, kFirstHand)).p, 1e-12));
  CHECK(next.objects[0].V_WO == last.objects[0].V_WO);
  // forgotten, counted, and not given later
  CHECK_THAT(next.seen[0].forgotten_W, IsNear({2e-3, 0, 0}, 1e-15));
  CHECK(next.seen[0].impulse_W == pushed.impulse_W);
  // it stands until the hand knows of it, and what is pushed until then is forgotten as well
  hand.t_ns += 1'000'000;
  pushed.impulse_W.f.x += 1e-3;
  const SceneFrame waiting = sim_step(first.model, second, {&hand}, hand.t_ns);
  CHECK(waiting.objects[0].X_WO == next.objects[0].X_WO);
  CHECK(waiting.objects[0].V_WO == next.objects[0].V_WO);
  CHECK_THAT(waiting.seen[0].forgotten_W, IsNear({3e-3, 0, 0}, 1e-15));
  hand.scene_seq = next.seq;
  pushed.impulse_time_W = pushed.impulse_time_W + 1e-3 * pushed.impulse_W;
  const SceneFrame after = sim_step(first.model, second, {&hand}, hand.t_ns + 1'000'000);
  CHECK_THAT(after.objects[0].V_WO.v,
             IsNear(last.objects[0].V_WO.v + Vec3{0, 0, -1e-3 * kGravity}, 1e-12));
}

TEST_CASE("bodies: one that falls for ever stays where the reach ends, and the rest goes on",
          "[sim][bodies]") {
  BodyScene scene = scene_with_ground();
  scene.config.sim_reach = 0.5;
  scene.add_box(edges(kEdge), {{1, 0, 0}, {}}, 0.01);
  scene.add_box(edges(kEdge), {{0, 0, 0.3}, {}}, 0.01);
  BodySim sim(scene);
  for (int k = 0; k < 1000; ++k) sim.step();
  const Vec3 stopped = sim.frame.objects[1].X_WO.p;
  CHECK(stopped.z == Approx(-0.5).margin(0.005));
  CHECK(sim.frame.objects[1].V_WO == Twist{});
  CHECK(response_of(sim.frame, 1)->mobility == std::array<double, 36>{});
  CHECK(sim.frame.objects[2].X_WO.p.z == Approx(kEdge / 2).margin(1e-4));
  CHECK(out_of_reach(scene.config, sim.frame).bodies == 1);
  // a sim that begins anew leaves it there
  SimState second;
  resume(sim.model, second, sim.frame);
  SceneFrame next{};
  for (int k = 1; k < 200; ++k) next = sim_step(sim.model, second, sim.t_ns + k * 1'000'000);
  CHECK(norm(next.objects[1].X_WO.p - stopped) < 1e-3);
}

TEST_CASE("bodies: a mesh that is not closed has no density, a flat one no mass", "[sim][bodies]") {
  BodyScene scene;
  ObjectConfig& sheet = scene.add(make_grid(0.05, 2), {}, 0);
  sheet.body.density = 1000;
  CHECK_THROWS_WITH(build_sim(scene.config, scene.shapes), Catch::Contains("not closed"));
  sheet.body = {};
  sheet.body.mass = 0.1;
  CHECK_THROWS_WITH(build_sim(scene.config, scene.shapes), Catch::Contains("flat"));
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for contact/detect/body/god_object6.cpp. Truth: closed forms, exact answers whether two
// meshes meet (triangle_pairs), and least constraint with a row for every two triangles that are
// near.
#include "contact/detect/body/god_object6.h"

#include <catch2/catch.hpp>
#include <deque>
#include <set>

#include "contact/query/proximity/mesh_distance.h"
#include "contact/shape/mesh/tool_body.h"
#include "contact/shape/parts/machine_parts.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kMargin = 1e-6;

/// A tool among objects, with its oracles.
struct World {
  std::deque<MeshShapeData> owned;
  std::vector<MeshShape> objects;
  std::vector<Pose> X_WO;
  MeshShapeData tool;
  ToolBody body;
  GodObject6Options options;

  explicit World(Soup tool_soup) : tool(build_shape(std::move(tool_soup))) {
    body = tool_body(tool.view().mesh, ToolConfig{});
    options.margin = kMargin;
  }
  void add(Soup soup, const Pose& X = {}) {
    owned.push_back(build_shape(std::move(soup)));
    objects.push_back(owned.back().view());
    X_WO.push_back(X);
  }
  GodObject6 make() const { return {objects, tool.view(), body, options}; }

  bool is_met(const Pose& X_WT) const {
    for (size_t i = 0; i < objects.size(); ++i) {
      const Pose X_OT = inverse(X_WO[i]) * X_WT;
      if (triangle_pairs(objects[i], tool.view(), X_OT, {}) > 0) return true;
    }
    return false;
  }
  double distance(const Pose& X_WT) const {
    double least = 1e9;
    for (size_t i = 0; i < objects.size(); ++i) {
      const Pose X_OT = inverse(X_WO[i]) * X_WT;
      least = std::min(least, mesh_distance(objects[i], tool.view(), X_OT, least).at_least);
    }
    return least;
  }
  double length_of(const Twist& motion) const {
    const double ratio = options.rotational_stiffness / options.translational_stiffness;
    return std::sqrt(norm_squared(motion.v) + ratio * norm_squared(motion.w));
  }
  Twist way(const Pose& from, const Pose& to) const {
    return {to.p - from.p, to_rotation_vector(to.q * conjugate(from.q))};
  }
  /// Feasible motion towards another pose, by all triangles within a band [m].
  double residual(const Pose& X_WT, const Pose& led_W, double band) const;
};

double World::residual(const Pose& X_WT, const Pose& led_W, double band) const {
  std::vector<MotionRow> rows;
  for (size_t i = 0; i < objects.size(); ++i) {
    const Pose X_OT = inverse(X_WO[i]) * X_WT;
    std::vector<NearPair> near(near_pairs(objects[i], tool.view(), X_OT, band, {}));
    near_pairs(objects[i], tool.view(), X_OT, band, near);
    for (const NearPair& pair : near) {
      const Vec3 n_O = (pair.at.point_b - pair.at.point_a) / pair.at.distance;
      const Vec3 r_W = X_WO[i] * pair.at.point_b - X_WT.p;
      rows.push_back(contact_row(r_W, rotate(X_WO[i].q, n_O),
                                 std::max(pair.at.distance - options.margin, 0.0), 0));
    }
  }
  Mat6 K;
  add_block(K, 0, 0, options.translational_stiffness * Mat3{});
  add_block(K, 3, 3, options.rotational_stiffness * Mat3{});
  return length_of(least_constraint(factor_metric(K), way(X_WT, led_W), rows).a);
}

/// A box of 10 mm over one of 20 mm whose top is at z = 10 mm: it rests with its origin at 15 mm.
World box_over_box() {
  World world(make_box({10e-3, 10e-3, 10e-3}));
  world.add(make_box({20e-3, 20e-3, 20e-3}));
  return world;
}
constexpr double kRest = 15e-3;

Soup make_angle(double leg, double width, double half) {
  return make_prism(
      {{width, width, 0}, {width, leg, 0}, {0, leg, 0}, {0, 0, 0}, {leg, 0, 0}, {leg, width, 0}},
      half);
}

Pose at(double x, double y, double z, const Quat& q = {}) {
  return {{x, y, z}, q};
}

bool is_same(const Pose& a, const Pose& b) {
  return a.p == b.p && a.q == b.q;
}

}  // namespace

TEST_CASE("god object of six degrees of freedom: a box pushed into a box rests at the margin") {
  World world = box_over_box();
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, at(1e-3, 2e-3, 18e-3)));
  const Pose led = at(1e-3, 2e-3, 5e-3);
  for (int step = 0; step < 20; ++step) {
    const GodObjectMove move = god.move(world.X_WO, led, 0);
    CHECK_FALSE(move.is_lost);
    const double gap = god.X_WG().p.z - kRest;
    CAPTURE(step, gap);
    CHECK(world.distance(god.X_WG()) >= 0.5 * kMargin);
    CHECK(gap <= 1.1 * kMargin);
    CHECK(move.is_settled);
    CHECK(move.n_active > 0);
  }
  CHECK(god.X_WG().p.z - kRest == Approx(kMargin).epsilon(0.1));
  // and leaves the way it came
  CHECK(god.move(world.X_WO, at(1e-3, 2e-3, 18e-3), 0).n_active == 0);
  CHECK_THAT(god.X_WG().p, IsNear({1e-3, 2e-3, 18e-3}, 0.05 * kMargin));
}

TEST_CASE("god object of six degrees of freedom: pushed at 45° it slides by what is tangential") {
  World world = box_over_box();
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, at(-3e-3, 0, kRest + kMargin)));
  for (int step = 1; step <= 30; ++step) {
    const double s = 0.2e-3 * step;
    const Pose led = at(-3e-3 + s, 0.5 * s, kRest - s);
    const GodObjectMove move = god.move(world.X_WO, led, 0);
    CAPTURE(step, move.is_settled);
    CHECK(world.distance(god.X_WG()) >= 0.5 * kMargin);
    CHECK_THAT(god.X_WG().p, IsNear({led.p.x, led.p.y, kRest + kMargin}, 0.2 * kMargin));
    CHECK(norm(to_rotation_vector(god.X_WG().q)) < 1e-3);
  }
}

TEST_CASE("god object of six degrees of freedom: in free space 1 − k_s/2 of the way is left") {
  World world = box_over_box();
  world.options.moves = 1;
  const Pose first = at(0, 0, 40e-3), led = at(5e-3, -3e-3, 60e-3);
  for (const double k_s : {0.5, 1.0}) {
    world.options.k_s = k_s;
    GodObject6 god = world.make();
    REQUIRE(god.place(world.X_WO, first));
    for (int n = 1; n <= 16; ++n) {
      god.move(world.X_WO, led, 0);
      const double left = norm(god.X_WG().p - led.p) / norm(first.p - led.p);
      CHECK(left == Approx(std::pow(1 - k_s / 2, n)).epsilon(1e-9));
    }
  }
  world.options.k_s = 2;
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, first));
  CHECK(god.move(world.X_WO, led, 0).free_fraction == 1);
  CHECK_THAT(god.X_WG().p, IsNear(led.p, 1e-15));
  // a rotation too, up to the largest allowed bend per move: the rest follows in later moves
  const Pose turned{led.p, from_rotation_vector({0.3, -0.2, 0.1})};
  for (int step = 0; step < 100; ++step) god.move(world.X_WO, turned, 0);
  CHECK(norm(world.way(god.X_WG(), turned).w) * world.body.radius < kMargin);
}

TEST_CASE(
    "god object of six degrees of freedom: what a way in a tight fit leaves is small, and gone "
    "once the hand rests") {
  const primitive::Hole fit{{20e-3, 40e-3, {64, 24}}, 0.05e-3, 40e-3};
  World world(make_peg(fit));
  world.add(make_hole(fit));
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, {}));
  Pose led;
  double most_left = 0;
  for (size_t step = 0; step < trials(60); ++step) {
    const double t = 1e-3 * static_cast<double>(step);
    led = at(1e-3 * std::sin(30 * t), 1e-3 * std::cos(40 * t), 0.1 * t,
             from_rotation_vector({0.02 * std::sin(20 * t), 0, t}));
    god.move(world.X_WO, led, 0.3e-3);
    REQUIRE_FALSE(world.is_met(god.X_WG()));
    const double left = world.residual(god.X_WG(), led, 20 * kMargin);
    CAPTURE(step);
    CHECK(left <= 6 * kMargin);
    most_left = std::max(most_left, left);
  }
  CHECK((most_left > 0.2 * kMargin || kSlowdown > 1));
  for (int step = 0; step < 3; ++step) god.move(world.X_WO, led, 0.3e-3);
  CHECK(world.residual(god.X_WG(), led, 20 * kMargin) <= 0.2 * kMargin);
}

TEST_CASE("god object of six degrees of freedom: it begins only where it is free") {
  World world = box_over_box();
  GodObject6 god = world.make();
  CHECK_FALSE(god.is_placed());
  CHECK_FALSE(god.place(world.X_WO, at(0, 0, 10e-3)));
  CHECK_FALSE(god.place(world.X_WO, at(0, 0, kRest + 0.49 * kMargin)));
  CHECK_FALSE(god.is_placed());
  CHECK(god.place(world.X_WO, at(0, 0, kRest + 0.51 * kMargin)));
  const Pose before = god.X_WG();
  CHECK_FALSE(god.place(world.X_WO, at(0, 0, 10e-3)));
  CHECK(god.is_placed());
  CHECK(is_same(god.X_WG(), before));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(god.place(world.X_WO, at(nan, 0, 40e-3)));
  CHECK_FALSE(god.place(world.X_WO, {{0, 0, 40e-3}, {nan, 0, 0, 1}}));
  // fully inside, and the other way round
  World inside(make_box({2e-3, 2e-3, 2e-3}));
  inside.add(make_icosphere(20e-3, 2));
  CHECK_FALSE(inside.make().place(inside.X_WO, at(1e-3, 0, 0)));
  World around(make_icosphere(20e-3, 2));
  around.add(make_box({2e-3, 2e-3, 2e-3}));
  CHECK_FALSE(around.make().place(around.X_WO, at(1e-3, 0, 0)));
  // of two balls that form one tool only the second is inside
  Soup two = make_icosphere(2e-3, 1);
  append(two, make_icosphere(2e-3, 1), {40e-3, 0, 0});
  World half_inside(two);
  half_inside.add(make_icosphere(20e-3, 2));
  CHECK_FALSE(half_inside.make().place(half_inside.X_WO, at(-40e-3, 0, 0)));
  CHECK(half_inside.make().place(half_inside.X_WO, at(0, 40e-3, 0)));
}

TEST_CASE("god object of six degrees of freedom: a free pose is found near one that is not") {
  World world = box_over_box();
  Random random(1);
  for (size_t trial = 0; trial < trials(50); ++trial) {
    GodObject6 god = world.make();
    const Pose X{random.in_box({-9e-3, -9e-3, -9e-3}, {9e-3, 9e-3, 9e-3}), random.pose(1).q};
    REQUIRE(god.place_near(world.X_WO, X));
    CHECK_FALSE(world.is_met(god.X_WG()));
    CHECK(world.distance(god.X_WG()) >= 0.5 * kMargin);
    CHECK(norm(god.X_WG().p - X.p) < 40e-3);
  }
  // back to where it was, if that is free
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, at(0, 0, 30e-3)));
  god.lose();
  REQUIRE(god.place_near(world.X_WO, at(0, 0, 9e-3)));
  CHECK(is_same(god.X_WG(), at(0, 0, 30e-3)));
}

TEST_CASE(
    "god object of six degrees of freedom: what begins inside one object is not placed beyond "
    "another",
    "[trap]") {
  World world(make_box({10e-3, 10e-3, 10e-3}));
  const double beside = GENERATE(8e-3, 24e-3, 40e-3);
  world.add(make_box({0.5, 0.5, 10e-3}));
  world.add(make_box({0.5, 0.5, 1e-3}), at(0, 0, beside));
  world.add(make_box({0.5, 0.5, 1e-3}), at(0, 0, -beside));
  GodObject6 god = world.make();
  // between the first and either of the others there is room for it, or none
  const bool has_room = beside - 5.5e-3 > 10e-3;
  REQUIRE(god.place_near(world.X_WO, at(0, 0, 1e-3)) == has_room);
  if (!has_room) return;
  CHECK_FALSE(world.is_met(god.X_WG()));
  CHECK(std::fabs(god.X_WG().p.z) < beside);
}

TEST_CASE("god object of six degrees of freedom: a plate of 0.01 mm at 10 m/s is not passed",
          "[trap]") {
  World world(make_icosphere(5e-3, 2));
  world.add(make_box({60e-3, 60e-3, 0.01e-3}));
  Random random(2);
  for (size_t trial = 0; trial < trials(50); ++trial) {
    GodObject6 god = world.make();
    const double z = random.uniform(6e-3, 20e-3);
    const Pose first{{random.uniform(-5e-3, 5e-3), 0, z}, random.pose(1).q};
    REQUIRE(god.place(world.X_WO, first));
    // 10 mm per millisecond
    for (int step = 1; step <= 5; ++step) {
      const Quat q = from_rotation_vector(0.1 * step * random.direction()) * first.q;
      const Pose led{first.p - Vec3{0, 0, 10e-3 * step}, q};
      REQUIRE_FALSE(god.move(world.X_WO, led, 0).is_lost);
      REQUIRE_FALSE(world.is_met(god.X_WG()));
      REQUIRE(god.X_WG().p.z > 4e-3);
    }
  }
}

TEST_CASE(
    "god object of six degrees of freedom: shaken it enters nothing, rocks to and fro nowhere, "
    "and where it settles no way on is left",
    "[trap]") {
  std::deque<World> worlds;
  worlds.emplace_back(make_bumpy_ball(3, 8e-3, 2));
  worlds.back().add(make_box({20e-3, 14e-3, 10e-3}));
  const primitive::Hole fit{{10e-3, 16e-3, {16, 3}}, 0.1e-3, 20e-3};
  worlds.emplace_back(make_peg(fit));
  worlds.back().add(make_hole(fit));
  worlds.emplace_back(make_angle(12e-3, 4e-3, 3e-3));
  worlds.back().add(make_angle(15e-3, 5e-3, 4e-3), at(-4e-3, -4e-3, 0));
  worlds.emplace_back(make_bumpy_ball(4, 6e-3, 1));
  worlds.back().add(make_box({20e-3, 20e-3, 4e-3}), at(0, 0, -6e-3));
  worlds.back().add(make_bumpy_ball(5, 7e-3, 2), at(9e-3, 0, 2e-3));
  Random random(6);
  const size_t steps = sweep(1600);  // per scene; 10⁶ with HAPTIC_TORTURE_SCALE = 625
  for (size_t w = 0; w < worlds.size(); ++w) {
    const World& world = worlds[w];
    GodObject6 god = world.make();
    Pose led{{0, 0, w == 1 ? 0 : 25e-3}, {}};
    REQUIRE(god.place(world.X_WO, led));
    size_t n_held = 0, n_settled = 0;
    double worst = 0, nearest = 1;
    for (size_t step = 0; step < steps; ++step) {
      // a hand that is drawn to the centre and sometimes jumps
      const double leap = step % 50 == 49 ? 10e-3 : random.uniform(0, 0.7e-3);
      const Vec3 back = 0.05 * (Vec3{0, 0, 2e-3} - led.p);
      const Vec3 turn = random.uniform(0, 0.1) * random.direction();
      led = {led.p + leap * random.direction() + back,
             normalized(from_rotation_vector(turn) * led.q)};
      const GodObjectMove move = god.move(world.X_WO, led, random.uniform(0, 1e-3));
      const Pose X = god.X_WG();
      CAPTURE(w, step, X.p, world.distance(X));
      REQUIRE_FALSE(move.is_lost);
      REQUIRE_FALSE(world.is_met(X));
      nearest = std::min(nearest, world.distance(X));
      REQUIRE(nearest > 0);
      n_held += move.n_active > 0 ? 1 : 0;
      n_settled += move.is_settled ? 1 : 0;
      if (!move.is_settled || step % 3 != 0) continue;
      const double left = world.residual(X, led, 8 * kMargin);
      worst = std::max(worst, left);
      CHECK(left <= 5.5 * kMargin);
    }
    CAPTURE(w, n_held, n_settled, worst, nearest);
    CHECK(n_held > steps / 10);
    CHECK(5 * n_settled > 3 * steps);
  }
}

TEST_CASE("god object of six degrees of freedom: it rides on what lifts and turns it") {
  World world = box_over_box();
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, at(0, 0, kRest + 2 * kMargin)));
  for (int step = 1; step <= 40; ++step) {
    const double t = 0.01 * step;
    const Pose X{{0, 0.1e-3 * step, 0.3e-3 * step}, from_rotation_vector({0.5 * t, 0, t})};
    world.X_WO[0] = X;
    // the hand stays where it was
    const GodObjectMove move = god.move(world.X_WO, at(0, 0, 12e-3), 20e-6);
    god.contacts(god.X_WG());
    CAPTURE(step);
    REQUIRE_FALSE(move.is_lost);
    REQUIRE_FALSE(world.is_met(god.X_WG()));
    CHECK(world.distance(god.X_WG()) >= 0.5 * kMargin);
    CHECK(world.distance(god.X_WG()) <= 3 * kMargin);
  }
  CHECK(god.X_WG().p.z > kRest + 0.2e-3 * 40);
}

TEST_CASE(
    "god object of six degrees of freedom: crushed it says so and waits, and goes on where its "
    "objects part or the hand leads it out",
    "[trap]") {
  const bool is_led_out = GENERATE(false, true);
  World world(make_bumpy_ball(7, 6e-3, 1));
  world.add(make_box({40e-3, 40e-3, 4e-3}), at(0, 0, -9e-3));
  world.add(make_box({40e-3, 40e-3, 4e-3}), at(0, 0, 9e-3));
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, {}));
  GodObjectMove move;
  const auto step = [&](double closer, const Pose& hand) {
    world.X_WO[0].p.z += closer;
    world.X_WO[1].p.z -= closer;
    move = god.move(world.X_WO, hand, 20e-6);
    god.contacts(hand);
    CAPTURE(god.X_WG().p, move.is_lost);
    if (!move.is_behind) {
      REQUIRE_FALSE(world.is_met(god.X_WG()));
      return;
    }
    // free of the objects at the poses it knows
    for (size_t i = 0; i < world.objects.size(); ++i) {
      const Pose X_OT = inverse(god.X_WO(i)) * god.X_WG();
      REQUIRE(triangle_pairs(world.objects[i], world.tool.view(), X_OT, {}) == 0);
    }
  };
  // through one of them
  const Pose through = at(0, 0, 60e-3);
  for (int k = 0; k < 30; ++k) step(0.1e-3, through);
  for (int k = 0; k < 30; ++k) step(0, through);
  REQUIRE(move.is_lost);
  if (is_led_out) {
    for (int k = 0; k < 60; ++k) step(0, at(60e-3, 0, 0));
    REQUIRE_FALSE(move.is_behind);
    CHECK(god.X_WG().p.x > 26e-3);
  } else {
    for (int k = 0; k < 30; ++k) step(-0.1e-3, through);
    REQUIRE_FALSE(move.is_behind);
    CHECK(std::fabs(god.X_WG().p.z) < 7e-3);
  }
  CHECK_FALSE(move.is_lost);
}

TEST_CASE(
    "god object of six degrees of freedom: jaws that close turn a tilted box level, whatever the "
    "hand does",
    "[trap]") {
  constexpr double kEdge = 30e-3, kRoom = 2e-3, kThick = 4e-3;
  const double tilt = GENERATE(-0.3, 0.1, 0.2, 0.35);
  const double step = GENERATE(10e-6, 100e-6);  // motion of each jaw per step [m]
  const double through = GENERATE(0.0, 30e-3);  // height of the hand; 30 mm is past a jaw [m]
  World world(make_box({kEdge, kEdge, kEdge}));
  const double open = kEdge * (std::cos(tilt) + std::sin(std::fabs(tilt))) + 0.2e-3;
  for (const double side : {-1.0, 1.0}) {
    world.add(make_box({80e-3, 80e-3, kThick}), at(0, 0, side * (open + kThick) / 2));
  }
  GodObject6 god = world.make();
  const Quat held = from_rotation_vector({0, tilt, 0});
  REQUIRE(god.place(world.X_WO, {{}, held}));
  const auto middle_to_jaw = [&] { return world.X_WO[1].p.z - kThick / 2; };
  while (middle_to_jaw() > (kEdge + kRoom) / 2) {
    world.X_WO[0].p.z += step;
    world.X_WO[1].p.z -= step;
    const Pose hand = at(0, 0, through, held);
    const GodObjectMove move = god.move(world.X_WO, hand, 2 * step);
    god.contacts(hand);
    CAPTURE(tilt, step, middle_to_jaw(), god.X_WG().p);
    REQUIRE_FALSE(move.is_lost);
    REQUIRE_FALSE(move.is_behind);
    REQUIRE_FALSE(world.is_met(god.X_WG()));
    REQUIRE(std::fabs(god.X_WG().p.z) < middle_to_jaw());
  }
}

TEST_CASE(
    "god object of six degrees of freedom: sheets that move are not let through where first "
    "they are followed in vain",
    "[trap]") {
  // a plate as a tool between equally thin plates: a small motion passes it completely
  World world(make_box({20e-3, 20e-3, 0.01e-3}));
  world.add(make_box({20e-3, 20e-3, 0.01e-3}), at(0, 0, -0.05e-3));
  world.add(make_box({20e-3, 20e-3, 0.01e-3}), at(0, 0, 0.05e-3));
  for (const double other : {0.0, 0.001e-3, -0.2e-3}) {
    for (const double step : {-0.2e-3, -0.15e-3, 0.2e-3}) {
      World scene = world;
      scene.objects = {scene.owned[0].view(), scene.owned[1].view()};
      GodObject6 god = scene.make();
      REQUIRE(god.place(scene.X_WO, {}));
      // rests on the lower one
      for (int k = 0; k < 5; ++k) god.move(scene.X_WO, at(0, 0, -1e-3), 20e-6);
      REQUIRE(!god.contacts(at(0, 0, -1e-3)).empty());
      // the upper one comes down through it, or the lower one up
      scene.X_WO[step < 0 ? 1 : 0].p.z += step;
      scene.X_WO[step < 0 ? 0 : 1].p.z += other;
      const double between = scene.X_WO[1].p.z - scene.X_WO[0].p.z;
      const GodObjectMove move = god.move(scene.X_WO, at(0, 0, -1e-3), 20e-6);
      CAPTURE(other, step, between, god.X_WG().p, scene.X_WO[0].p, scene.X_WO[1].p);
      if (move.is_behind) continue;
      CHECK(god.X_WG().p.z > scene.X_WO[0].p.z);
      CHECK(god.X_WG().p.z < scene.X_WO[1].p.z);
    }
  }
}

TEST_CASE("god object of six degrees of freedom: objects that move right after it is placed",
          "[trap]") {
  World world(make_box({20e-3, 20e-3, 0.01e-3}));
  world.add(make_box({20e-3, 20e-3, 0.01e-3}), at(0, 0, -0.05e-3));
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, {}));
  god.move(world.X_WO, {}, 20e-6);
  // the plate is now above it; the tool is re-placed over the plate, which goes back up
  REQUIRE(god.place(world.X_WO, at(0, 0, -0.15e-3)));
  world.X_WO[0].p.z = -0.2e-3;
  const GodObjectMove move = god.move(world.X_WO, at(0, 0, -0.15e-3), 20e-6);
  if (!move.is_behind) CHECK(god.X_WG().p.z < world.X_WO[0].p.z);
}

TEST_CASE("god object of six degrees of freedom: the same questions have the same answers") {
  const auto run = [](const Pose& X_WV, std::vector<Pose>& poses) {
    World world(make_bumpy_ball(8, 6e-3, 2));
    world.add(make_box({20e-3, 14e-3, 10e-3}), X_WV);
    world.add(make_bumpy_ball(9, 6e-3, 2), X_WV * at(11e-3, 0, 8e-3));
    GodObject6 god = world.make();
    REQUIRE(god.place(world.X_WO, X_WV * at(0, 0, 14e-3)));
    Random random(10);
    Pose led = at(0, 0, 14e-3);
    for (int step = 0; step < 60; ++step) {
      const Vec3 turn = random.uniform(0, 0.03) * random.direction();
      led = {led.p + Vec3{0.15e-3, 0, -0.1e-3} + 0.1e-3 * random.direction(),
             normalized(from_rotation_vector(turn) * led.q)};
      god.move(world.X_WO, X_WV * led, 50e-6);
      poses.push_back(inverse(X_WV) * god.X_WG());
    }
    REQUIRE(norm(poses.back().p - led.p) > 1e-3);
  };
  std::vector<Pose> first, again, elsewhere;
  run({}, first);
  run({}, again);
  run(Random(11).pose(0.3), elsewhere);
  for (size_t i = 0; i < first.size(); ++i) {
    CAPTURE(i);
    REQUIRE(is_same(first[i], again[i]));
    // rounding may end it a move earlier, within the tolerance that counts as arrived
    CHECK_THAT(elsewhere[i].p, IsNear(first[i].p, 0.05 * kMargin));
    CHECK(norm(to_rotation_vector(elsewhere[i].q * conjugate(first[i].q))) < 1e-7);
  }
}

TEST_CASE(
    "god object of six degrees of freedom: contacts that hold it, then those that would be "
    "broken") {
  World world = box_over_box();
  world.add(make_box({4e-3, 20e-3, 20e-3}), at(8e-3, 0, 20e-3));
  GodObject6 god = world.make();
  REQUIRE(god.place(world.X_WO, at(0.9e-3, 0, kRest + 5 * kMargin)));
  // on the floor, the wall 0.1 mm away
  GodObjectMove move;
  for (int step = 0; step < 3; ++step) move = god.move(world.X_WO, at(0.9e-3, 0, 14e-3), 0.3e-3);
  const Pose answered = at(1.5e-3, 0, 14e-3);
  const auto contacts = god.contacts(answered);
  REQUIRE(move.n_active > 0);
  REQUIRE(contacts.size() > move.n_active);
  bool has_wall = false;
  double last = -1e9;
  std::set<std::pair<uint32_t, uint64_t>> features;
  for (const GodObjectContact& c : contacts) features.emplace(c.object, c.at.feature);
  CHECK(features.size() == contacts.size());
  CHECK(features.count({0, 0}) == 0);
  for (size_t i = 0; i < contacts.size(); ++i) {
    const NearContact& c = contacts[i].at;
    CAPTURE(i, c.distance, contacts[i].object);
    CHECK(c.distance >= 0.5 * kMargin);
    CHECK(norm(c.normal_A) == Approx(1));
    CHECK(norm(c.point_b - c.point_a - c.distance * c.normal_A) < 1e-12);
    if (i < move.n_active) {
      CHECK(c.distance <= 1.1 * kMargin);
      CHECK(contacts[i].object == 0);
      continue;
    }
    has_wall |= contacts[i].object == 1;
    // contacts violated by this pose come first, then the nearest
    const Vec3 moved_by = answered.p - god.X_WG().p;
    const double slack = dot(c.normal_A, moved_by) + c.distance - kMargin;
    const double rank = slack < 0 ? slack : c.distance;
    CHECK(rank >= last - 1e-9);
    last = rank;
  }
  CHECK(has_wall);
  CHECK(world.distance(god.X_WG()) >= 0.5 * kMargin);
}

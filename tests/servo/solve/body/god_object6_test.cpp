// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/god_object6.h"

#include <limits>

#include "proto/math/qp.h"
#include "proto/wire/renderer.h"
#include "tests/support/near.h"
#include "tests/support/rigid_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

RigidLoop god_object() {
  return RigidLoop(Renderer::kGodObject6);
}

/// A translation, and a rotation equally large at the tool's rim.
Twist random_way(Random& random, double most) {
  return {random.uniform(0, most) * random.direction(),
          random.uniform(0, most / 0.05) * random.direction()};
}

Pose at(const Vec3& p_W) {
  return {p_W, {}};
}

}  // namespace

TEST_CASE("god-object6: a cube on one edge and on four corners", "[servo]") {
  // side 1, M = diag(1, 1/6); the inertia acts as k_R
  RigidLoop loop = god_object();
  loop.tick.coupling = {1, 0, 1.0 / 6, 0, 0, 0};
  const auto one = rigid_set({}, {{{0.5, -0.5, 0}, {0, 1, 0}, 0}});
  const BodySolution out = loop.hold(at({0, -1, 0}), *one);
  CHECK_THAT(out.proxy.X_WT.p, IsNear({0, -0.6, 0}, 1e-12));
  CHECK_THAT(to_rotation_vector(out.proxy.X_WT.q), IsNear({0, 0, 1.2}, 1e-12));
  CHECK_THAT(out.F_hand_W.f, IsNear({0, 0.4, 0}, 1e-12));
  CHECK_THAT(out.F_hand_W.t, IsNear({0, 0, 0.2}, 1e-12));
  CHECK(out.n_pushing == 1);

  std::vector<TouchPoint> bottom;
  for (const double x : {-0.5, 0.5}) {
    for (const double z : {-0.5, 0.5}) bottom.push_back({{x, -0.5, z}, {0, 1, 0}, 0});
  }
  RigidLoop four = god_object();
  four.tick.coupling = loop.tick.coupling;
  const BodySolution flat = four.hold(at({0, -1, 0}), *rigid_set({}, bottom));
  CHECK_THAT(flat.proxy.X_WT.p, IsNear({}, 1e-12));
  CHECK_THAT(flat.F_hand_W.f, IsNear({0, 1, 0}, 1e-12));
  CHECK_THAT(flat.F_hand_W.t, IsNear({}, 1e-12));
  CHECK_THAT(flat.push_W[0].f, IsNear({0, 1, 0}, 1e-12));
}

TEST_CASE("god-object6: free space is exactly free, however fast", "[servo][trap]") {
  RigidLoop loop = god_object();
  loop.tick.coupling = {800, 2, 2, 5e-3, 8, 0.5};
  const auto materials = rough(0.5);
  loop.materials = materials;
  // towards a floor 1 mm ahead, where a damper would act before the spring
  const auto set = rigid_set(at({0, 0, 0.021}), corners_on_floor(0.02, -0.02, 0.001));
  for (int i = 0; i < 100; ++i) {
    const double z = 0.021 - 0.5e-3 * (i % 2), turn = 1e-4 * i;
    ToolMotion hand{{{0, 1e-3 * i, z}, from_rotation_vector({0, 0, turn})}, {{0, 0, -0.5}, {}}};
    const BodySolution out = loop.step(hand, *set);
    REQUIRE(out.F_hand_W == Wrench{});
    REQUIRE(out.proxy.X_WT == hand.X_WT);
    REQUIRE(out.n_pushing == 0);
  }
}

TEST_CASE("god-object6: without friction a plane pushes along its normal alone", "[servo][trap]") {
  RigidLoop loop = god_object();
  loop.tick.coupling.translational_damping = GENERATE(0, 2);
  const auto set = rigid_set(at({0, 0, 0.02}), corners_on_floor(0.02, -0.02));
  for (int i = 0; i < 200; ++i) {
    const double way = 1e-4 * i;
    const ToolMotion hand{at({way, 0, 0.02 - way}), {{0.1, 0, -0.1}, {}}};
    const BodySolution out = loop.step(hand, *set);
    const double tangential = std::hypot(out.F_hand_W.f.x, out.F_hand_W.f.y);
    REQUIRE(tangential <= 1e-9 * norm(out.F_hand_W.f));
    REQUIRE(out.F_hand_W.f.z ==
            Approx(800 * way + loop.tick.coupling.translational_damping * 0.1 * (i > 0 ? 1 : 0)));
  }
}

TEST_CASE("god-object6: the force lies in the cone of the contacts", "[servo]") {
  // KKT conditions for the contacts as they are: feasible, and the force in their cone
  Random random(1);
  RigidLoop loop = god_object();
  loop.tick.coupling = {800, 0, 2, 0, 0, 0};
  size_t pushed = 0;
  for (size_t i = 0; i < trials(4000); ++i) {
    const Pose X_WG = random.pose(0.1);
    const auto touches = random_touches(random, 0.05, 2e-3);
    const auto set = rigid_set(X_WG, touches);
    const Twist a_u{random.uniform(0, 5e-3) * random.direction(),
                    random.uniform(0, 0.1) * random.direction()};
    loop.god_object = {};
    loop.tick.coupling.translational_damping = i % 2 == 0 ? 0 : 2;
    const Twist V{random.uniform(0, 0.3) * random.direction(), random.direction()};
    const BodySolution out = loop.step(ToolMotion{moved(X_WG, a_u), V}, *set);
    REQUIRE(out.converged);
    std::vector<MotionRow> rows;
    const Twist a = way_between(X_WG, out.proxy.X_WT);
    for (const TouchPoint& t : touches) {
      const Vec3 r = rotate(X_WG.q, t.tool_point_T);
      rows.push_back(contact_row(r, t.normal, t.gap, 1));
      REQUIRE(dot(rows.back().J, a) - rows.back().b >= -1e-12);
    }
    // no motion that all contacts allow has the force against it: project it onto the cone
    Mat6 weight;
    add_block(weight, 0, 0, Mat3{});
    add_block(weight, 3, 3, 400 * Mat3{});
    std::vector<MotionRow> cone = rows;
    for (MotionRow& row : cone) row.b = 0;
    // polar decomposition: −F = cone part + rest, and the rest is zero
    const MotionMetric metric = factor_metric(weight);
    const Twist push = response(metric, -out.F_hand_W);
    const ConstrainedMotion rest = least_constraint(metric, push, cone);
    const double size = norm(out.F_hand_W.f) + 20 * norm(out.F_hand_W.t);
    REQUIRE(norm(rest.a.v) + 20 * norm(rest.a.w) <= 1e-9 * size);
    if (size > 0) ++pushed;
  }
  CHECK(pushed > trials(4000) / 2);
}

TEST_CASE("god-object6: a tight peg moves freely along its hole", "[servo][trap]") {
  // contacts all round with zero gap, some of them opposite
  RigidLoop loop = god_object();
  loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
  const auto set = rigid_set({}, wall_of_hole(0));
  for (int i = 0; i < 300; ++i) {
    // pulled along, turned about the axis, pushed and tilted against the walls
    const double way = 1e-4 * i;
    const ToolMotion hand{{{2e-3, 1e-3, way}, from_rotation_vector({0.02, 0, 0.05})},
                          {{0, 0, 0.1}, {}}};
    const BodySolution out = loop.step(hand, *set);
    REQUIRE(out.converged);
    REQUIRE_THAT(out.proxy.X_WT.p, IsNear({0, 0, way}, 1e-9));
    REQUIRE(std::fabs(out.F_hand_W.f.z) <= 1e-9 * norm(out.F_hand_W.f));
    REQUIRE(std::fabs(out.F_hand_W.t.z) <= 1e-9 * norm(out.F_hand_W.f));
    REQUIRE_THAT(out.F_hand_W.f, IsNear({-1.6, -0.8, 0}, 1e-6));
  }
  // along the axis there is no force
  const BodySolution free = god_object().hold(at({0, 0, 0.01}), *set);
  CHECK(free.F_hand_W == Wrench{});
}

TEST_CASE("god-object6: another feature of the same surface changes nothing", "[servo][trap]") {
  // slides over facets: a new contact and a new verified pose each tick
  RigidLoop loop = god_object();
  double before = 0;
  for (int i = 0; i < 200; ++i) {
    const double x = 2e-4 * i;
    auto set = rigid_set(at({x, 0, 0}), {{{0.001 * (i % 5), 0, 0}, {0, 0, 1}, 0},
                                         {{-0.02, 0.02, 0}, {0, 0, 1}, 0},
                                         {{-0.02, -0.02, 0}, {0, 0, 1}, 0},
                                         {{0.02, 0, 0}, {0, 0, 1}, 0}});
    const BodySolution out = loop.hold(at({x, 0, -5e-3}), *set);
    REQUIRE(out.F_hand_W.f.z == Approx(4).epsilon(1e-9));
    if (i > 0) REQUIRE(std::fabs(out.F_hand_W.f.z - before) < 1e-9);
    before = out.F_hand_W.f.z;
  }
}

TEST_CASE("god-object6: contacts fade with their age, without a step", "[servo][trap]") {
  RigidLoop loop = god_object();
  const double k = 800, depth = 5e-3, speed = 0.05;
  loop.tick.coupling = {k, 2, 2, 0, 0, 0};
  const auto materials = rough(GENERATE(0.0, 0.5));
  loop.materials = materials;
  const auto floor = rigid_set({}, corners_on_floor(0.02, 0));
  const double full = k * depth + 2 * speed;
  const ToolMotion hand{at({0, 0, -depth}), {{0, 0, -speed}, {}}};
  double before = loop.step(hand, *floor).F_hand_W.f.z;
  CHECK(before == Approx(full));
  for (int i = 1; i <= 100; ++i) {
    loop.tick.weight = i <= 50 ? 1 - 0.02 * i : 0.02 * (i - 50);
    const double now = loop.step(hand, *floor).F_hand_W.f.z;
    REQUIRE(std::fabs(now - before) <= 0.03 * full);
    // back inside, it follows within a few ticks
    if (i <= 50) REQUIRE(now == Approx(loop.tick.weight * full).margin(1e-9));
    before = now;
  }
  for (int i = 0; i < 60; ++i) before = loop.step(hand, *floor).F_hand_W.f.z;
  CHECK(before == Approx(full));
}

TEST_CASE("god-object6: sticks within the cone of friction and slides at its edge", "[servo]") {
  const double mu = GENERATE(0.1, 0.4, 0.8, 1.5);
  const double degrees = GENERATE(-0.5, 0.5);
  const double angle = std::atan(mu) + degrees * kDegree;
  const auto materials = rough(mu);
  RigidLoop loop = god_object();
  loop.materials = materials;
  // low enough not to tip over
  const auto floor = rigid_set(at({0, 0, 0.002}), corners_on_floor(0.02, -0.002));
  const double depth = 3e-3;
  CAPTURE(mu, degrees);
  loop.hold(at({0, 0, 0.002}), *floor);
  BodySolution out(loop.tick);
  for (int i = 1; i <= 50; ++i) {
    const double d = depth * i / 50;
    out = loop.hold(at({d * std::tan(angle), 0, 0.002 - d}), *floor);
    REQUIRE(out.converged);
    const double tangential = std::hypot(out.F_hand_W.f.x, out.F_hand_W.f.y);
    REQUIRE(tangential <= mu * out.F_hand_W.f.z * (1 + 1e-6));
  }
  const double expected = degrees < 0 ? 0 : depth * (std::tan(angle) - mu);
  CHECK_THAT(out.proxy.X_WT.p, IsNear({expected, 0, 0.002}, 1e-8));
  CHECK(out.held_back_W.x == Approx(expected - depth * std::tan(angle)));
}

TEST_CASE("god-object6: what sticks does not creep", "[servo][trap]") {
  RigidLoop loop = god_object();
  const auto materials = rough(0.5);
  loop.materials = materials;
  loop.hold(at({0, 0, 0.02}), *rigid_set(at({0, 0, 0.02}), corners_on_floor(0.02, -0.02)));
  const Pose hand{{1e-3, 0, 0.017}, from_rotation_vector({0, 0, 0.01})};
  for (size_t i = 0; i < trials(10000); ++i) {
    // contact's own proxy follows the hand without friction
    const auto set = rigid_set(at({1e-3 * (i % 2 == 0), 0, 0.02}), corners_on_floor(0.02, -0.02));
    const BodySolution out = loop.hold(hand, *set);
    REQUIRE_THAT(out.proxy.X_WT.p, IsNear({0, 0, 0.02}, 1e-8));
    REQUIRE_THAT(to_rotation_vector(out.proxy.X_WT.q), IsNear({}, 1e-6));
  }
}

TEST_CASE("god-object6: sliding takes the dynamic ratio, rest the static one", "[servo]") {
  RigidLoop loop = god_object();
  auto materials = rough(0);
  materials.of_object[0].friction_static = 0.8, materials.of_object[0].friction_dynamic = 0.3;
  loop.materials = materials;
  const auto floor = rigid_set({}, corners_on_floor(0.02, 0));
  loop.hold(at({}), *floor);
  const double depth = 3e-3;
  double most = 0;
  BodySolution out(loop.tick);
  for (int i = 0; i <= 60; ++i) {
    out = loop.hold(at({1e-4 * i, 0, -depth}), *floor);
    most = std::max(most, -out.F_hand_W.f.x / out.F_hand_W.f.z);
  }
  CHECK(most == Approx(0.8).epsilon(0.03));
  CHECK(-out.F_hand_W.f.x / out.F_hand_W.f.z == Approx(0.3).epsilon(1e-6));
}

TEST_CASE("god-object6: shading turns the force, its own normals change nothing", "[servo]") {
  Random random(2);
  for (size_t i = 0; i < trials(500); ++i) {
    const Pose X_WG = random.pose(0.1);
    const auto set = rigid_set(X_WG, random_touches(random, 0.05, 2e-3));
    const Pose hand = moved(X_WG, {5e-3 * random.direction(), 0.05 * random.direction()});
    RigidLoop plain = god_object(), shaded = god_object();
    const BodySolution expected = plain.hold(hand, *set);
    // the normals with other roundings
    for (Contact& c : set->contacts) c.shading_normal_O = (1 + 1e-15) * c.normal_O;
    const BodySolution out = shaded.hold(hand, *set);
    REQUIRE_THAT(out.F_hand_W.f, IsNear(expected.F_hand_W.f, 1e-10));
    REQUIRE_THAT(out.F_hand_W.t, IsNear(expected.F_hand_W.t, 1e-11));
    REQUIRE_THAT(out.proxy.X_WT.p, IsNear(expected.proxy.X_WT.p, 1e-13));
  }
  const Vec3 m = normalized(Vec3{0.2, 0.1, 1});
  auto set = rigid_set({}, {{{}, {0, 0, 1}, 0}});
  set->contacts[0].shading_normal_O = m;
  const BodySolution out = god_object().hold(at({0, 0, -5e-3}), *set);
  CHECK_THAT(normalized(out.F_hand_W.f), IsNear(m, 1e-12));
  CHECK(out.F_hand_W.f.z == Approx(4));
  CHECK_THAT(out.push_W[0].f, IsNear(out.F_hand_W.f, 1e-12));
}

TEST_CASE("god-object6: a grating tilts the force by its slope", "[servo]") {
  auto materials = rough(GENERATE(0.0, 0.2));
  TextureConfig& texture = materials.of_object[0].texture;
  texture.kind = TextureKind::kGrating;
  texture.amplitude = 1e-5;
  texture.period = 1e-3;
  RigidLoop loop = god_object();
  loop.materials = materials;
  const auto set = rigid_set({}, {{{}, {0, 0, 1}, 0}});
  const double slope = texture.amplitude * 2 * 3.14159265358979 / texture.period;
  // at the crest's flank, where the height rises along x
  const BodySolution out = loop.hold(at({0, 0, -5e-3}), *set);
  CHECK(out.F_hand_W.f.x / out.F_hand_W.f.z == Approx(-slope).epsilon(1e-3));
}

TEST_CASE("rigid tools: a moving object takes the proxy along", "[servo]") {
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  const bool has_mass = renderer == Renderer::kConstrained6;
  const double mu = GENERATE(0.0, 0.5);
  const auto materials = rough(mu);
  RigidLoop loop(renderer);
  loop.materials = materials;
  loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
  const auto set = rigid_set(at({0, 0, 0.02}), corners_on_floor(0.02, -0.02));
  // a body with mass is not turned, and slides where there is no friction
  const Twist V{{has_mass && mu == 0 ? 0 : 0.1, 0, 0.05}, {0, has_mass ? 0 : 0.3, 0}};
  for (int i = 0; i < (has_mass ? 2000 : 1000); ++i) {
    // the hand moves with the object, deep inside it
    const Pose X_WO = extrapolate({}, V, 1e-3 * i);
    const Pose X_WT = X_WO * at({0, 0, 0.018});
    loop.tick.X_WO[0] = X_WO;
    loop.tick.V_WO[0] = V;
    const Twist V_WT{velocity_at(V, X_WT.p - X_WO.p), V.w};
    const BodySolution out = loop.step(ToolMotion{X_WT, V_WT}, *set);
    if (has_mass && i < 500) continue;
    REQUIRE_THAT(out.F_hand_W.f, IsNear(rotate(X_WO.q, {0, 0, 1.6}), has_mass ? 1e-5 : 1e-8));
    REQUIRE_THAT(inverse(X_WO) * out.proxy.X_WT.p, IsNear({0, 0, 0.02}, has_mass ? 1e-8 : 1e-9));
    if (has_mass) REQUIRE_THAT(out.proxy.V_WT.v, IsNear(V.v, 1e-7));
    if (!has_mass) REQUIRE_THAT(out.F_hand_W.t, IsNear({}, 1e-9));
  }
  if (has_mass) return;
  // outside it both move alike and there is no force
  loop.tick.X_WO[0] = {};
  const BodySolution out = loop.step(ToolMotion{at({0, 0, 0.021}), V}, *set);
  CHECK(out.F_hand_W == Wrench{});
}

TEST_CASE("god-object6: the spring ends at its bounds, the direction stays", "[servo]") {
  RigidLoop loop = god_object(), bound = god_object();
  bound.tick.coupling.max_force = 2;
  bound.tick.coupling.max_torque = 0.01;
  const auto set = rigid_set({}, {{{0.02, 0, 0}, {0, 0, 1}, 0}, {{0, 0.01, 0}, {0, 0.6, 0.8}, 0}});
  const Pose hand{{0, -2e-3, -8e-3}, from_rotation_vector({0.1, 0.2, 0})};
  const Wrench full = loop.hold(hand, *set).F_hand_W, least = bound.hold(hand, *set).F_hand_W;
  CHECK(norm(full.f) > 2);
  const double share = norm(least.f) / norm(full.f);
  CHECK(std::max(norm(least.f) / 2, norm(least.t) / 0.01) == Approx(1));
  CHECK_THAT(least.f, IsNear(share * full.f, 1e-12));
  CHECK_THAT(least.t, IsNear(share * full.t, 1e-12));
}

TEST_CASE("rigid tools: what is not finite renders nothing, and the next tick begins anew",
          "[servo][trap]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Renderer renderer = GENERATE(Renderer::kGodObject6, Renderer::kConstrained6);
  const auto good = rigid_set({}, corners_on_floor(0.02, 0));
  for (const int what : {0, 1, 2, 3, 4, 5, 6, 7}) {
    CAPTURE(row_of(renderer).name, what);
    RigidLoop loop(renderer);
    loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
    loop.hold(at({0, 0, -1e-3}), *good);
    ContactSet set = *good;
    if (what == 0) set.X_WG.p.x = nan;
    if (what == 1) set.contacts[2].normal_O.y = nan;
    if (what == 2) set.contacts[1].tool_point_T.y = nan;
    if (what == 3) set.contacts[3].object = 1;
    if (what == 4) loop.tick.X_WO[0].q.w = nan;
    if (what == 5) loop.tick.V_WO[0].w.x = nan;
    if (what == 6) set.X_WG.q.x = nan;
    if (what == 7) set.contacts[2].object_point_O.y = nan;
    const BodySolution out = loop.hold(at({0, 0, -1e-3}), set);
    CHECK_FALSE(out.finite);
    CHECK(out.F_hand_W == Wrench{});
    CHECK(is_finite(out.proxy.X_WT));
    CHECK_FALSE(loop.god_object.started);
    CHECK_FALSE(loop.constrained.started);
    loop.tick.X_WO[0] = {};
    loop.tick.V_WO[0] = {};
    for (int i = 0; i < 1000; ++i) loop.hold(at({0, 0, -1e-3}), *good);
    CHECK(loop.hold(at({0, 0, -1e-3}), *good).F_hand_W.f.z == Approx(0.8));
  }
}

TEST_CASE("god-object6: whatever contact says, force and proxy are bounded by the hand",
          "[servo][trap]") {
  // objects that move, verified poses that jump, contacts that come and go
  Random random(6);
  for (const double mu : {0.0, 0.4}) {
    const auto materials = rough(mu);
    RigidLoop loop = god_object();
    loop.materials = materials;
    loop.tick.coupling = {800, 0, 2, 0, 0, 0};
    loop.tick.X_WO.resize(2);
    loop.tick.V_WO.resize(2);
    size_t pushed = 0, failed = 0;
    Pose X_WG;
    for (size_t i = 0; i < trials(5000); ++i) {
      if (random.index(3) == 0) X_WG = moved(X_WG, random_way(random, 2e-3));
      if (random.index(10) == 0) X_WG = {};
      const auto set = rigid_set(X_WG, random_touches(random, 0.05, 2e-3));
      set->objects.resize(2);
      for (Contact& c : set->contacts) c.object = static_cast<uint32_t>(random.index(2));
      set->contacts[0].object = 0;
      const Twist V = random_way(random, 0.1);
      loop.tick.V_WO[1] = V;
      loop.tick.weight = random.index(4) == 0 ? random.uniform(0, 1) : 1;
      const Pose hand = moved(X_WG, random_way(random, 5e-3));
      const BodySolution out = loop.hold(hand, *set);
      REQUIRE(out.finite);
      failed += out.converged ? 0 : 1;
      REQUIRE(is_finite(out.proxy.X_WT));
      REQUIRE(std::fabs(dot(out.proxy.X_WT.q, out.proxy.X_WT.q) - 1) < 1e-12);
      if (out.n_pushing == 0) {
        REQUIRE(out.F_hand_W == Wrench{});
        REQUIRE(out.proxy.X_WT == hand);
        continue;
      }
      ++pushed;
      // it is the spring to the proxy, to second order in the rotation
      const Twist way = way_between(hand, out.proxy.X_WT);
      REQUIRE_THAT(out.F_hand_W.f, IsNear(800 * way.v, 1e-8));
      REQUIRE_THAT(out.F_hand_W.t, IsNear(2 * way.w, 0.1));
      // and the sum of what the objects push
      const Wrench sum = out.push_W[0] + out.push_W[1];
      REQUIRE_THAT(sum.f, IsNear(out.F_hand_W.f, 1e-9));
      REQUIRE_THAT(sum.t, IsNear(out.F_hand_W.t, 1e-10));
    }
    CHECK(pushed > trials(5000) / 2);
    // friction may jam; without it there is always a solution
    if (mu == 0) CHECK(failed == 0);
  }
}

TEST_CASE("god-object6: held between two objects it gives way to neither, and one carries it",
          "[servo]") {
  // a floor at rest, and a plate above that moves sideways
  const auto materials = rough(GENERATE(0.0, 0.5));
  RigidLoop loop = god_object();
  loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
  loop.materials = materials;
  auto touches = corners_on_floor(0.02, 0);
  for (const double x : {-0.02, 0.02}) touches.push_back({{x, 0, 0.04}, {0, 0, -1}, 0});
  const auto set = rigid_set({}, touches);
  set->objects.resize(2);
  loop.tick.X_WO.resize(2);
  loop.tick.V_WO.resize(2);
  set->contacts[4].object = set->contacts[5].object = 1;
  loop.hold({}, *set);
  for (int i = 1; i < 300; ++i) {
    loop.tick.X_WO[1].p.x = 1e-4 * i;
    loop.tick.V_WO[1].v.x = 0.1;
    const BodySolution out = loop.hold(at({0, 0, i % 20 < 10 ? 1e-3 : -1e-3}), *set);
    REQUIRE(out.converged);
    REQUIRE(std::fabs(out.proxy.X_WT.p.z) < 1e-9);
    // pressed to the plate it is carried along, pressed to the floor it is not
    const double up = out.F_hand_W.f.z;
    REQUIRE((i % 20 < 10 ? -up : up) == Approx(0.8).epsilon(1e-6));
  }
}

TEST_CASE("god-object6: a wall ahead does not brake before it is touched", "[servo][trap]") {
  RigidLoop loop = god_object();
  loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
  const double ahead = 3e-4;
  auto touches = corners_on_floor(0.02, 0);
  touches.push_back({{0.02, 0, 0.01}, {-1, 0, 0}, ahead});
  const auto set = rigid_set({}, touches);
  loop.hold({}, *set);
  // slides over the floor at 0.2 m/s: the damper reaches 0.5 mm ahead
  for (int i = 1; i <= 3; ++i) {
    const double x = 2e-4 * i;
    const BodySolution out = loop.step(ToolMotion{at({x, 0, -1e-3}), {{0.2, 0, 0}, {}}}, *set);
    if (x < ahead) REQUIRE(std::fabs(out.F_hand_W.f.x) < 1e-12);
    if (x > ahead) REQUIRE(out.F_hand_W.f.x < -0.2 * 2 * 0.9);
  }
}

TEST_CASE("god-object6: damped contacts never contradict one another", "[servo][trap]") {
  Random random(8);
  for (size_t i = 0; i < trials(300); ++i) {
    RigidLoop loop = god_object();
    loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
    const Pose X_WG = random.pose(0.1);
    const auto set = rigid_set(X_WG, random_touches(random, 0.05, 2e-3));
    const Twist V = random_way(random, 0.1);
    for (int k = 0; k < 50; ++k) {
      REQUIRE(loop.step(ToolMotion{moved(X_WG, 1e-3 * k * V), V}, *set).converged);
    }
  }
}

TEST_CASE("god-object6: over a ball the plane falls away as the ball does, and no further",
          "[servo][trap]") {
  // the top of a ball of 50 mm; the hand slides off beside it, with one old set
  const double radius = 0.05, depth = 1e-3;
  auto set = rigid_set({}, {{{0, 0, 0}, {0, 0, 1}, 0}});
  set->contacts[0].extent = 0.02;
  for (int i = 0; i <= 40; ++i) {
    const double beside = 1e-4 * i, fallen = 0.5 * beside * beside / radius;
    const Pose hand = at({beside, 0, -fallen - depth});
    set->contacts[0].curvature = 1 / radius;
    RigidLoop loop = god_object();
    const BodySolution curved = loop.hold(hand, *set);
    CAPTURE(beside);
    CHECK_THAT(curved.proxy.X_WT.p, IsNear({beside, 0, -fallen}, 1e-12));
    CHECK(curved.F_hand_W.f.z == Approx(800 * depth).epsilon(1e-9));
    // the normal stays that of the contact
    CHECK(std::hypot(curved.F_hand_W.f.x, curved.F_hand_W.f.y) < 1e-12);
    set->contacts[0].curvature = 0;
    RigidLoop plain = god_object();
    CHECK_THAT(plain.hold(hand, *set).proxy.X_WT.p, IsNear({beside, 0, 0}, 1e-12));
  }
}

TEST_CASE("god-object6: friction holds the proxy where the surface has not fallen",
          "[servo][trap]") {
  // the hand moves on, the proxy sticks: it must not sink as if it had moved on as well
  const auto materials = rough(2);
  auto set = rigid_set({}, {{{0, 0, 0}, {0, 0, 1}, 0}});
  set->contacts[0].extent = 0.02;
  set->contacts[0].curvature = 20;
  RigidLoop loop = god_object();
  loop.materials = materials;
  loop.hold(at({0, 0, -2e-3}), *set);
  const BodySolution stuck = loop.hold(at({2e-3, 0, -2e-3}), *set);
  CHECK_THAT(stuck.proxy.X_WT.p, IsNear({}, 1e-9));
}

TEST_CASE("god-object6: past the extent of a plane there is exactly nothing", "[servo][trap]") {
  auto set = rigid_set({}, corners_on_floor(5e-3, -5e-3));
  for (uint32_t i = 0; i < 4; ++i) set->contacts[i].extent = 4e-3;
  double last = 0;
  for (int i = 0; i <= 100; ++i) {
    const Pose hand = at({1e-4 * i, 0, -1e-3});
    RigidLoop loop = god_object();
    const BodySolution out = loop.hold(hand, *set);
    CAPTURE(hand.p.x);
    if (hand.p.x < 3.99e-3) CHECK(out.F_hand_W.f.z == Approx(0.8).epsilon(1e-9));
    // it fades over a tenth, without a step
    if (i > 0) CHECK(std::fabs(out.F_hand_W.f.z - last) <= 0.8 * 1e-4 / 4e-4 * 1.01);
    last = out.F_hand_W.f.z;
    if (hand.p.x < 4.41e-3) continue;
    CHECK(out.F_hand_W == Wrench{});
    CHECK(out.proxy.X_WT == hand);
  }
}

TEST_CASE("god-object6: a plane holds while the proxy is within its extent", "[servo][trap]") {
  // in a corner the hand is far along one wall only because it is deep in the other
  auto set = rigid_set({}, {{{0, 0, 0}, {0, 0, 1}, 0}, {{0, 0, 0}, {-1, 0, 0}, 0}});
  for (uint32_t i = 0; i < 2; ++i) set->contacts[i].extent = 1e-3;
  RigidLoop loop = god_object();
  const BodySolution out = loop.hold(at({5e-3, 0, -5e-3}), *set);
  CHECK_THAT(out.proxy.X_WT.p, IsNear({}, 1e-12));
  CHECK_THAT(out.F_hand_W.f, IsNear({-4, 0, 4}, 1e-9));
}

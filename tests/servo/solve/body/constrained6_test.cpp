// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/constrained6.h"
#include "servo/solve/coupled_body.h"

#include "proto/math/lcp.h"
#include "proto/wire/renderer.h"
#include "tests/support/near.h"
#include "tests/support/rigid_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kH = 1e-3;

/// A box of 0.1 kg, its corners 2 cm from the centre.
RigidLoop constrained() {
  RigidLoop loop(Renderer::kConstrained6);
  loop.tick.coupling = {800, 2, 2, 5e-3, 0, 0};
  return loop;
}

double energy(const RigidLoop& loop) {
  const BodyMotion& body = loop.constrained.body;
  const Vec3 w = rotate(conjugate(body.X_WC.q), body.V_WC.w);
  const Vec3& i = loop.tick.tool.inertia_T;
  return 0.5 * (loop.tick.tool.mass * norm_squared(body.V_WC.v) + i.x * w.x * w.x +
                i.y * w.y * w.y + i.z * w.z * w.z);
}

/// Sets the body loose, as it is.
void let_go(RigidLoop& loop, const BodyMotion& body) {
  loop.tick.coupling = {};
  loop.constrained.started = true;
  loop.constrained.body = body;
}

}  // namespace

TEST_CASE("constrained6: a pulled box rests on four corners", "[servo]") {
  RigidLoop loop = constrained();
  const auto materials = rough(GENERATE(0.0, 0.5));
  loop.materials = materials;
  loop.tick.tool.centre_T = {0.003, -0.002, 0.001};
  const auto floor = rigid_set({{0, 0, 0.02}, {}}, corners_on_floor(0.02, -0.02));
  BodySolution out(loop.tick);
  for (int i = 0; i < 2000; ++i) out = loop.hold({{0, 0, 0.015}, {}}, *floor);
  const Pose rest = out.proxy.X_WT;
  CHECK_THAT(rest.p, IsNear({0, 0, 0.02}, 1e-9));
  CHECK_THAT(out.F_hand_W.f, IsNear({0, 0, 800 * 5e-3}, 1e-6));
  // Σ λ = h F, and the hand feels what pushes the body
  CHECK_THAT(out.push_W[0].f, IsNear(out.F_hand_W.f, 1e-6));
  CHECK_THAT(out.push_W[0].t, IsNear(out.F_hand_W.t, 1e-7));
  for (size_t i = 0; i < trials(10000); ++i) out = loop.hold({{0, 0, 0.015}, {}}, *floor);
  CHECK_THAT(out.proxy.X_WT.p, IsNear(rest.p, 1e-10));
  CHECK_THAT(to_rotation_vector(out.proxy.X_WT.q), IsNear({}, 1e-9));
}

TEST_CASE("constrained6: sticks within the cone of friction and slides at its edge", "[servo]") {
  const double mu = GENERATE(0.1, 0.4, 0.8);
  const double degrees = GENERATE(-0.5, 0.5);
  const double angle = std::atan(mu) + degrees * kDegree;
  CAPTURE(mu, degrees);
  const auto materials = rough(mu);
  RigidLoop loop = constrained();
  loop.materials = materials;
  const Vec3 start{0, 0, 0.002};
  const auto floor = rigid_set({start, {}}, corners_on_floor(0.02, -0.002));
  const double pull = 3e-3;
  BodySolution out(loop.tick);
  loop.hold({start, {}}, *floor);
  // an incline seen from the box: the pull grows slowly in a constant direction
  const auto hand_at = [&](int i) {
    const double way = pull * std::min(i, 500) / 500;
    return Pose{start + way * Vec3{std::sin(angle), 0, -std::cos(angle)}, {}};
  };
  double slipped = 0;
  for (int i = 1; i <= 3000; ++i) {
    out = loop.hold(hand_at(i), *floor);
    REQUIRE(out.converged);
    const double tangential = std::hypot(out.push_W[0].f.x, out.push_W[0].f.y);
    REQUIRE(tangential <= mu * out.push_W[0].f.z * (1 + 1e-6) + 1e-9);
    REQUIRE_THAT(out.proxy.X_WT.p, IsNear({out.proxy.X_WT.p.x, 0, start.z}, 1e-8));
    slipped = out.proxy.X_WT.p.x;
  }
  // it slips until the spring is back at the edge of the cone, a little further by its inertia
  const double edge = pull * std::max(0.0, std::sin(angle) - mu * std::cos(angle));
  if (degrees < 0) CHECK(std::fabs(slipped) < 1e-9);
  if (degrees > 0) CHECK(slipped == Approx(edge).epsilon(0.05));
  const double at_rest = slipped;
  for (size_t i = 0; i < trials(10000); ++i) out = loop.hold(hand_at(500), *floor);
  CHECK(std::fabs(out.proxy.X_WT.p.x - at_rest) < 1e-8);
}

TEST_CASE("constrained6: the step without friction is that of the complementarity problem",
          "[servo]") {
  Random random(3);
  LcpSolver lcp(kMaxContacts);
  size_t compared = 0, constraining = 0;
  for (size_t i = 0; i < trials(1000); ++i) {
    RigidLoop loop = constrained();
    loop.tick.tool.inertia_T = {1e-4, 2e-4, 2.5e-4};
    const Pose X_WG = random.pose(0.1);
    const auto touches = random_touches(random, 0.05, 1e-3);
    let_go(loop, {X_WG, {random.uniform(0, 0.5) * random.direction(), 5 * random.direction()}});
    const Twist before = loop.constrained.body.V_WC;
    const BodySolution out = loop.hold(X_WG, *rigid_set(X_WG, touches));
    REQUIRE(out.converged);
    std::vector<MotionRow> rows;
    for (const TouchPoint& t : touches) {
      MotionRow row = contact_row(rotate(X_WG.q, t.tool_point_T), t.normal, t.gap, 1);
      row.b /= kH;
      rows.push_back(row);
    }
    const Mat3 R = to_matrix(X_WG.q);
    const Vec3& inertia = loop.tick.tool.inertia_T;
    const Mat3 scaled =
        from_columns(inertia.x * R.column(0), inertia.y * R.column(1), inertia.z * R.column(2));
    const MotionMetric metric = factor_metric(mass_matrix(0.1, scaled * transpose(R)));
    for (const LcpMethod method : {LcpMethod::kPivoting, LcpMethod::kGaussSeidel}) {
      const ImpulseStep step = lcp.step(method, metric, before, rows, 100000);
      if (!step.converged) continue;
      const Twist v = loop.constrained.body.V_WC;
      REQUIRE_THAT(v.v, IsNear(step.v.v, 1e-8));
      REQUIRE_THAT(v.w, IsNear(step.v.w, 1e-7));
      ++compared;
      constraining += step.v == before ? 0 : 1;
    }
  }
  CHECK(compared > trials(1000));
  CHECK(constraining > compared / 2);
}

TEST_CASE("constrained6: pivoting leads the body as the solver of friction does without friction",
          "[servo]") {
  Random random(6);
  size_t pushed = 0, differ = 0;
  for (size_t i = 0; i < trials(1000); ++i) {
    const Pose X_WG = random.pose(0.1);
    const auto set = rigid_set(X_WG, random_touches(random, 0.05, 1e-3));
    const Twist V{random.uniform(0, 0.5) * random.direction(), 5 * random.direction()};
    const ToolMotion hand{moved(X_WG, {5e-3 * random.direction(), 0.1 * random.direction()}), V};
    RigidLoop loops[] = {constrained(), constrained()};
    loops[1].model.solver = RigidSolver::kLcp;
    BodySolution out[] = {BodySolution(loops[0].tick), BodySolution(loops[1].tick)};
    for (int tick = 0; tick < 5; ++tick) {
      for (size_t k = 0; k < 2; ++k) {
        RigidLoop& loop = loops[k];
        loop.tick.tool.inertia_T = {1e-4, 2e-4, 2.5e-4};
        if (tick == 0) loop.constrained = {true, {X_WG, V}, {}};
        out[k] = loop.step(hand, *set);
        REQUIRE(out[k].converged);
      }
      const Twist &a = out[0].proxy.V_WT, &b = out[1].proxy.V_WT;
      REQUIRE_THAT(b.v, IsNear(a.v, 1e-8));
      REQUIRE_THAT(b.w, IsNear(a.w, 1e-7));
      REQUIRE_THAT(out[1].F_hand_W.f, IsNear(out[0].F_hand_W.f, 1e-7));
      REQUIRE_THAT(out[1].F_hand_W.t, IsNear(out[0].F_hand_W.t, 1e-8));
      REQUIRE_THAT(out[1].push_W[0].f, IsNear(out[0].push_W[0].f, 1e-5));
      pushed += out[1].n_pushing > 0;
      differ += a == b ? 0 : 1;
    }
  }
  CHECK(pushed > trials(1000));
  // in their roundings: there are two solvers
  CHECK(differ > 0);
}

TEST_CASE("constrained6: where pivoting finds no answer the other solver does", "[servo][trap]") {
  // one place held from both sides, by directions too near to tell apart
  std::vector<TouchPoint> touches;
  for (int i = 0; i < 20; ++i) {
    const Vec3 n = normalized(Vec3{1e-6 * i, 0, 1});
    touches.push_back({{0, 0, -0.02}, n, 0});
    touches.push_back({{1e-7 * i, 0, 0.02}, -n, 0});
  }
  const auto set = rigid_set({}, touches);
  RigidLoop loops[] = {constrained(), constrained()};
  loops[1].model.solver = RigidSolver::kLcp;
  for (int tick = 0; tick < 500; ++tick) {
    BodySolution out[] = {BodySolution(loops[0].tick), BodySolution(loops[1].tick)};
    for (size_t k = 0; k < 2; ++k) out[k] = loops[k].hold({{0, 0, -0.01}, {}}, *set);
    REQUIRE(std::fabs(out[1].proxy.X_WT.p.z) < 1e-6);
    REQUIRE_THAT(out[1].F_hand_W.f, IsNear(out[0].F_hand_W.f, 1e-3));
  }
}

TEST_CASE("constrained6: a body that nobody leads never gains energy", "[servo][trap]") {
  Random random(4);
  for (const double mu : {0.0, 0.3, 1.0}) {
    const auto materials = rough(mu);
    RigidLoop loop = constrained();
    loop.tick.tool.inertia_T = {1e-4, 2e-4, 2.5e-4};
    loop.materials = materials;
    double before = 0;
    size_t lost = 0;
    for (size_t i = 0; i < trials(10000); ++i) {
      if (i % 20 == 0) {
        let_go(loop, {random.pose(0.1), {random.direction(), 20 * random.direction()}});
        before = energy(loop);
      }
      // contacts all around it, some slightly violated
      const Pose X_WG = loop.constrained.body.X_WC;
      const auto set = rigid_set(X_WG, random_touches(random, 0.05, 5e-3));
      if (i % 3 == 0) set->contacts[0].object_point_O += 1e-4 * set->contacts[0].normal_O;
      loop.hold({}, *set);
      const double now = energy(loop);
      REQUIRE(now <= before * (1 + 1e-9) + 1e-18);
      lost += now < before * (1 - 1e-6) ? 1 : 0;
      before = now;
    }
    CHECK(lost > trials(10000) / 20);
  }
}

TEST_CASE("constrained6: free of contacts it turns on, and follows the hand", "[servo]") {
  RigidLoop loop = constrained();
  loop.tick.tool.inertia_T = {1e-4, 2e-4, 2.5e-4};
  const auto none = rigid_set({}, {});
  let_go(loop, {{}, {{0.1, 0, 0}, {1, 2, 3}}});
  const double before = energy(loop);
  for (int i = 0; i < 1000; ++i) loop.hold({}, *none);
  CHECK(energy(loop) == Approx(before).epsilon(1e-12));
  CHECK_THAT(loop.constrained.body.X_WC.p, IsNear({0.1, 0, 0}, 1e-12));

  RigidLoop led = constrained();
  led.tick.tool.centre_T = {0.01, 0, 0.02};
  const Pose hand{{0.01, 0.02, 0.03}, from_rotation_vector({0.3, 0, 0.4})};
  led.hold(Pose{}, *none);
  BodySolution out(led.tick);
  for (int i = 0; i < 3000; ++i) out = led.hold(hand, *none);
  CHECK_THAT(out.proxy.X_WT.p, IsNear(hand.p, 1e-6));
  CHECK_THAT(way_between(out.proxy.X_WT, hand).w, IsNear({}, 1e-6));
  CHECK_THAT(out.F_hand_W.f, IsNear({}, 1e-3));
}

TEST_CASE("constrained6: begins at the hand as far as the contacts let it", "[servo]") {
  const auto floor = rigid_set({{0, 0, 0.02}, {}}, corners_on_floor(0.02, -0.02));
  RigidLoop loop = constrained();
  const ToolMotion above{{{0.01, 0, 0.03}, from_rotation_vector({0.2, 0, 0})}, {{0.1, 0, 0}, {}}};
  const BodySolution free = loop.step(above, *floor);
  CHECK_THAT(free.proxy.X_WT.p, IsNear(above.X_WT.p, 1e-12));
  CHECK_THAT(free.F_hand_W.f, IsNear({}, 1e-9));
  RigidLoop below = constrained();
  const BodySolution held = below.hold({{0.01, 0, 0.01}, {}}, *floor);
  CHECK_THAT(held.proxy.X_WT.p, IsNear({0.01, 0, 0.02}, 1e-9));
  CHECK(held.n_pushing > 0);
}

TEST_CASE("constrained6: comes out of what it is behind, a part each tick", "[servo]") {
  RigidLoop loop = constrained();
  const double behind = 1e-3;
  let_go(loop, {{{0, 0, 0.02 - behind}, {}}, {}});
  const auto floor = rigid_set({{0, 0, 0.02}, {}}, corners_on_floor(0.02, -0.02));
  double left = behind;
  for (int i = 0; i < 40; ++i) {
    loop.hold({}, *floor);
    const double now = 0.02 - loop.constrained.body.X_WC.p.z;
    REQUIRE(now == Approx(left * 2 / 3).margin(1e-12));
    // none of it remains as speed
    REQUIRE(norm(loop.constrained.body.V_WC.v) < 1e-12);
    left = now;
  }
}

TEST_CASE("constrained6: stays in a tight hole, and finite whatever leads it", "[servo][trap]") {
  Random random(5);
  const auto materials = rough(GENERATE(0.0, 0.3));
  RigidLoop loop = constrained();
  loop.materials = materials;
  const auto set = rigid_set({}, wall_of_hole(1e-5));
  loop.hold(Pose{}, *set);
  for (size_t i = 0; i < trials(5000); ++i) {
    const ToolMotion hand{random.pose(0.02), {random.direction(), random.direction()}};
    const BodySolution out = loop.step(hand, *set);
    REQUIRE(is_finite(out.proxy.X_WT));
    REQUIRE(is_finite(out.F_hand_W));
    const Vec3& p = out.proxy.X_WT.p;
    REQUIRE(std::hypot(p.x, p.y) < 2e-5);
    // along the axis nothing holds it
    loop.constrained.body.X_WC.p.z = 0;
  }
}

TEST_CASE("constrained6: a tool without mass is not a body: it rests, and a flag says so",
          "[servo]") {
  RigidLoop loop = constrained();
  loop.tick.tool.mass = 0;
  loop.tick.coupling = {};
  const BodySolution out = loop.hold(Pose{}, *rigid_set({}, corners_on_floor(0.02, 0)));
  CHECK_FALSE(out.converged);
  CHECK(is_finite(out.proxy.X_WT));
}

TEST_CASE("coupling: its symmetric Jacobian is the true one where nothing is stretched",
          "[servo]") {
  Random random(9);
  const Coupling coupling{800, 2, 2, 5e-3, 8, 0.5};
  const ToolBody tool{0.1, {1e-4, 1e-4, 1e-4}, {0.01, -0.02, 0.03}, 0.05};
  for (size_t i = 0; i < trials(200); ++i) {
    const ToolMotion at{random.pose(0.1), {}};
    const BodyMotion proxy = motion_of_centre(tool, at);
    const Pose away = moved(at.X_WT, {0.02 * random.direction(), 0.3 * random.direction()});
    for (const ToolMotion& hand : {at, ToolMotion{away, {random.direction(), {}}}}) {
      const BodyWrench plain = coupling_wrench(coupling, tool, hand, proxy);
      const BodyWrench symmetric = symmetric_coupling_wrench(coupling, tool, hand, proxy);
      REQUIRE(symmetric.F_W == plain.F_W);
      for (size_t r = 0; r < 6; ++r) {
        for (size_t c = 0; c < 6; ++c) {
          REQUIRE(symmetric.by_motion(r, c) == Approx(symmetric.by_motion(c, r)).margin(1e-9));
          if (hand.X_WT == at.X_WT) {
            REQUIRE(symmetric.by_motion(r, c) == Approx(plain.by_motion(r, c)).margin(1e-9));
          }
        }
      }
      const Twist way{random.direction(), 20 * random.direction()};
      REQUIRE(dot(symmetric.by_motion * way, way) <= 1e-9);
    }
  }
}

TEST_CASE("constrained6: follows a ball and leaves a plane at its extent", "[servo][trap]") {
  const double radius = 0.05;
  auto set = rigid_set({}, {{{0, 0, 0}, {0, 0, 1}, 0}});
  set->contacts[0].extent = 4e-3;
  set->contacts[0].curvature = 1 / radius;
  RigidLoop loop(Renderer::kConstrained6);
  loop.tick.coupling = {800, 20, 2, 0.02, 0, 0};
  for (int i = 0; i < 200; ++i) loop.hold({{0, 0, -1e-3}, {}}, *set);
  // 0.1 m/s: it lies on the ball as far as the plane holds
  for (int i = 0; i <= 120; ++i) {
    const double beside = 1e-4 * i;
    const BodySolution out = loop.step({{{beside, 0, -1e-3}, {}}, {{0.1, 0, 0}, {}}}, *set);
    const Vec3 p = out.proxy.X_WT.p;
    CAPTURE(beside, p);
    // the plane is that of the place where the tick began, which is higher
    const double above = p.z + 0.5 * p.x * p.x / radius;
    if (p.x < 3.9e-3) CHECK(above < 1e-5);
    if (p.x < 3.9e-3) CHECK(above > -1e-9);
    if (std::min(p.x, beside) > 4.5e-3) CHECK(out.n_pushing == 0);
  }
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/god_object6.h"

#include <limits>

#include "proto/math/qp.h"
#include "tests/support/near.h"
#include "tests/support/rigid_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kDegree = 0.017453292519943295;

std::vector<MaterialConfig> rough(double friction) {
  std::vector<MaterialConfig> materials(1);
  materials[0].friction_static = materials[0].friction_dynamic = friction;
  return materials;
}

RigidLoop god_object() {
  return RigidLoop(Renderer::kGodObject6);
}

Pose at(const Vec3& p_W) {
  return {p_W, {}};
}

}  // namespace

TEST_CASE("god-object6: a cube on one edge and on four corners", "[servo]") {
  // algorithms.md 6.3: side 1, M = diag(1, 1/6); the inertia stands for k_R
  RigidLoop loop = god_object();
  loop.model.coupling = {1, 0, 1.0 / 6, 0, 0, 0};
  const auto one = rigid_set({}, {{{0.5, -0.5, 0}, {0, 1, 0}, 0}});
  const BodySolution out = loop.step(at({0, -1, 0}), *one);
  CHECK_THAT(out.proxy.X_WT.p, IsNear({0, -0.6, 0}, 1e-12));
  CHECK_THAT(to_rotation_vector(out.proxy.X_WT.q), IsNear({0, 0, 1.2}, 1e-12));
  CHECK_THAT(out.F_hand_W.f, IsNear({0, 0.4, 0}, 1e-12));
  CHECK_THAT(out.F_hand_W.t, IsNear({0, 0, 0.2}, 1e-12));
  CHECK(out.n_pushing == 1);

  std::vector<Touch> bottom;
  for (const double x : {-0.5, 0.5}) {
    for (const double z : {-0.5, 0.5}) bottom.push_back({{x, -0.5, z}, {0, 1, 0}, 0});
  }
  RigidLoop four = god_object();
  four.model.coupling = loop.model.coupling;
  const BodySolution flat = four.step(at({0, -1, 0}), *rigid_set({}, bottom));
  CHECK_THAT(flat.proxy.X_WT.p, IsNear({}, 1e-12));
  CHECK_THAT(flat.F_hand_W.f, IsNear({0, 1, 0}, 1e-12));
  CHECK_THAT(flat.F_hand_W.t, IsNear({}, 1e-12));
  CHECK_THAT(flat.push_W[0].f, IsNear({0, 1, 0}, 1e-12));
}

TEST_CASE("god-object6: free space is exactly free, however fast", "[servo][trap]") {
  RigidLoop loop = god_object();
  loop.model.coupling = {800, 2, 2, 5e-3, 8, 0.5};
  const auto materials = rough(0.5);
  loop.model.materials = materials;
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
  loop.model.coupling.translational_damping = GENERATE(0, 2);
  const auto set = rigid_set(at({0, 0, 0.02}), corners_on_floor(0.02, -0.02));
  for (int i = 0; i < 200; ++i) {
    const double way = 1e-4 * i;
    const ToolMotion hand{at({way, 0, 0.02 - way}), {{0.1, 0, -0.1}, {}}};
    const BodySolution out = loop.step(hand, *set);
    const double tangential = std::hypot(out.F_hand_W.f.x, out.F_hand_W.f.y);
    REQUIRE(tangential <= 1e-9 * norm(out.F_hand_W.f));
    REQUIRE(out.F_hand_W.f.z ==
            Approx(800 * way + loop.model.coupling.translational_damping * 0.1 * (i > 0 ? 1 : 0)));
  }
}

TEST_CASE("god-object6: the force lies in the cone of the contacts", "[servo]") {
  // Karush–Kuhn–Tucker against the contacts as they are: feasible, and the force in their cone
  Random random(1);
  RigidLoop loop = god_object();
  loop.model.coupling = {800, 0, 2, 0, 0, 0};
  size_t pushed = 0;
  for (size_t i = 0; i < trials(4000); ++i) {
    const Pose X_WG = random.pose(0.1);
    const auto touches = random_touches(random, 0.05, 2e-3);
    const auto set = rigid_set(X_WG, touches);
    const Twist a_u{random.uniform(0, 5e-3) * random.direction(),
                    random.uniform(0, 0.1) * random.direction()};
    loop.god_object = {};
    loop.model.coupling.translational_damping = i % 2 == 0 ? 0 : 2;
    const Twist V{random.uniform(0, 0.3) * random.direction(), random.direction()};
    const BodySolution out = loop.step(ToolMotion{moved(X_WG, a_u), V}, *set);
    REQUIRE(out.converged);
    std::vector<MotionRow> rows;
    const Twist a = way_between(X_WG, out.proxy.X_WT);
    for (const Touch& t : touches) {
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
    // the polar decomposition: −F = what the cone makes + the rest, the rest is zero
    const MotionMetric metric = factor_metric(weight);
    const Twist push = response(metric, -out.F_hand_W);
    const ConstrainedMotion rest = least_constraint(metric, push, cone);
    const double size = norm(out.F_hand_W.f) + 20 * norm(out.F_hand_W.t);
    REQUIRE(norm(rest.a.v) + 20 * norm(rest.a.w) <= 1e-9 * size);
    if (size > 0) ++pushed;
  }
  CHECK(pushed > trials(4000) / 2);
}

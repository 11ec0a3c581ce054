// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for servo/render/body_solver.cpp. Truth: closed forms, projections onto convex bodies,
// the same motion seen from a frame that turns.
#include "proto/math/units.h"
#include "servo/render/body_solver.h"

#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kSpring = 800;
constexpr double kTickForce = kMostForceRate * kTick;  // [N]

WantedForce step_of(const Wrench& F_W, const Pose& X_WT = {}, uint32_t carrier = kMaxObjects) {
  return {F_W, X_WT, carrier, kSpring, 2, 1e-3};
}

}  // namespace

TEST_CASE("force continuity: a step becomes a ramp of the stated rate", "[servo]") {
  const std::array<Pose, kMaxObjects> X_WO{};
  FeltStep state;
  CHECK(limit_felt_step(state, step_of({}), X_WO) == Wrench{});
  const Vec3 way = normalized(Vec3{1, 2, -2});
  for (int i = 1; i <= 10; ++i) {
    const Wrench F = limit_felt_step(state, step_of({4 * way, {}}), X_WO);
    CHECK_THAT(F.f, IsNear(std::min(i * kTickForce, 4.0) * way, 1e-12));
    CHECK(F.t == Vec3{});
  }
  // what the hand moves the spring by comes at once, in addition
  const Wrench F = limit_felt_step(state, step_of({}, {{1e-3, 0, 0}, {}}), X_WO);
  CHECK_THAT(F.f, IsNear((4 - kTickForce - kSpring * 1e-3) * way, 1e-12));
}

TEST_CASE("force continuity: torques count by the lever of the springs", "[servo]") {
  const std::array<Pose, kMaxObjects> X_WO{};
  FeltStep state;
  limit_felt_step(state, step_of({}), X_WO);
  // √(k_T/k_R) = 20 / m
  const Wrench F = limit_felt_step(state, step_of({{}, {0, 1, 0}}), X_WO);
  CHECK_THAT(F.t, IsNear({0, kTickForce / 20, 0}, 1e-12));
}

TEST_CASE("force continuity: the first force, and none, pass as they are", "[servo]") {
  const std::array<Pose, kMaxObjects> X_WO{};
  FeltStep state;
  const Wrench F{{1, 2, 30}, {4, 5, 6}};
  CHECK(limit_felt_step(state, step_of(F), X_WO) == F);
  state = {};
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    CHECK(limit_felt_step(state, step_of({}, random.pose(1)), X_WO) == Wrench{});
  }
}

TEST_CASE("force continuity: the spring to a convex body at rest is never held back",
          "[servo][trap]") {
  // a ball and a box; hands from rest to 100 m/s
  const std::array<Pose, kMaxObjects> X_WO{};
  Random random(2);
  for (size_t i = 0; i < trials(200); ++i) {
    FeltStep state;
    const bool is_ball = i % 2 == 0;
    const double reach = std::pow(10, random.uniform(-6, -1));
    Vec3 p = 0.05 * random.direction();
    for (int k = 0; k < 100; ++k) {
      p += random.uniform(0, reach) * random.direction();
      // the free space is the convex one: a hand outside is drawn back in
      const Vec3 foot = is_ball ? (norm(p) > 0.05 ? 0.05 * normalized(p) : p)
                                : Vec3{std::clamp(p.x, -0.03, 0.03), std::clamp(p.y, -0.02, 0.02),
                                       std::clamp(p.z, -0.04, 0.04)};
      const Wrench F{kSpring * (foot - p), {}};
      REQUIRE(limit_felt_step(state, step_of(F, {p, {}}, 0), X_WO) == F);
    }
  }
}

TEST_CASE("force continuity: between two forces of a cone it stays in the cone", "[servo]") {
  const std::array<Pose, kMaxObjects> X_WO{};
  Random random(3);
  for (size_t i = 0; i < trials(500); ++i) {
    const Vec3 n = random.direction();
    const double mu = random.uniform(0, 1);
    const auto any = [&] {
      const Vec3 side = normalized(cross(n, random.direction()));
      return random.uniform(0, 8) * (n + random.uniform(0, mu) * side);
    };
    FeltStep state;
    limit_felt_step(state, step_of({any(), {}}), X_WO);
    for (int k = 0; k < 20; ++k) {
      const Vec3 f = limit_felt_step(state, step_of({any(), {}}), X_WO).f;
      REQUIRE(norm(f - dot(f, n) * n) <= mu * dot(f, n) + 1e-12);
    }
  }
}

TEST_CASE("force continuity: the last force goes along with the object that carried the tool",
          "[servo][trap]") {
  const Twist V{{0.2, -0.1, 0.3}, {2, -3, 1}};
  FeltStep still, moving;
  Random random(4);
  Wrench wanted{{1, 2, 3}, {0.1, 0, -0.1}};
  for (int i = 0; i < 200; ++i) {
    if (i % 20 == 0) wanted = {5 * random.direction(), 0.2 * random.direction()};
    const Pose X_OT{{1e-5 * i, 0, -5e-3}, from_rotation_vector({0.05, -1e-3 * i, 0.01})};
    std::array<Pose, kMaxObjects> X_WO{};
    const Wrench here = limit_felt_step(still, step_of(wanted, X_OT, 3), X_WO);
    X_WO[3] = extrapolate({}, V, 1e-3 * i);
    const Quat& q = X_WO[3].q;
    const Wrench turned{rotate(q, wanted.f), rotate(q, wanted.t)};
    const Wrench there = limit_felt_step(moving, step_of(turned, X_WO[3] * X_OT, 3), X_WO);
    REQUIRE_THAT(rotate(conjugate(q), there.f), IsNear(here.f, 1e-9));
    REQUIRE_THAT(rotate(conjugate(q), there.t), IsNear(here.t, 1e-10));
  }
}

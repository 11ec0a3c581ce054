// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/soft_proxy.h"

#include "tests/support/near.h"
#include "tests/support/rigid.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// A box of 40 mm on a floor at z = 0, touched by n of its points.
ContactSet floor_contacts(size_t n) {
  ContactSet set{};
  set.objects.resize(1);
  set.contacts.resize(n);
  set.n_active = static_cast<uint32_t>(n);
  for (size_t i = 0; i < n; ++i) {
    Contact& c = set.contacts[i];
    const double angle = 2 * 3.14159265358979 * static_cast<double>(i) / static_cast<double>(n);
    c.tool_point_T = {0.02 * std::cos(angle), 0.02 * std::sin(angle), -0.02};
    c.object_point_O = {0.02 * std::cos(angle), 0.02 * std::sin(angle), 0};
    c.normal_O = {0, 0, 1};
  }
  return set;
}

SoftProxyModel model_of(SoftSolver solver) {
  SoftProxyModel model;
  model.solver = solver;
  model.contact_stiffness = 2000;
  return model;
}

BodyTick tick_of(const Pose& X_WT, const ContactSet* contacts) {
  BodyTick tick;
  tick.X_WO.resize(1);
  tick.V_WO.resize(1);
  tick.hand = {X_WT, {}};
  tick.contacts = contacts;
  tick.coupling = {800, 0.5, 1, 1e-3, 0, 0};
  return tick;
}

BodySolution held_at(const SoftProxyModel& model, SoftProxyState& state, const Pose& X_WT,
                     const ContactSet* contacts) {
  return solve_soft_proxy(model, state, tick_of(X_WT, contacts));
}

}  // namespace

TEST_CASE("soft proxy: direct rendering is n times as stiff on n contacts", "[servo][trap]") {
  // ∂F/∂z = n·k
  for (const size_t n : {4u, 16u, 64u}) {
    const ContactSet set = floor_contacts(n);
    SoftProxyState state;
    const auto at = [&](double z) {
      return held_at(model_of(SoftSolver::kDirect), state, {{0, 0, z}, {}}, &set).F_hand_W.f.z;
    };
    const double slope = (at(0.0188) - at(0.019)) / 2e-4;
    CHECK(slope == Approx(2000.0 * static_cast<double>(n)).epsilon(1e-9));
  }
}

TEST_CASE("soft proxy: dynamics comes to rest where the equilibrium is", "[servo]") {
  const ContactSet set = floor_contacts(4);
  const Pose X_WT{{0.001, 0, 0.015}, from_rotation_vector({0.02, 0.01, 0})};
  SoftProxyState dynamic, still;
  BodySolution d(BodyTick{}), q(BodyTick{});
  SoftProxyModel with_mass = model_of(SoftSolver::kPenaltyDynamics);
  with_mass.contact_damping = 1;
  for (int i = 0; i < 4000; ++i) d = held_at(with_mass, dynamic, X_WT, &set);
  for (int i = 0; i < 20; ++i) q = held_at(model_of(SoftSolver::kQuasiStatic), still, X_WT, &set);
  CHECK(q.converged);
  CHECK_THAT(d.F_hand_W.f, IsNear(q.F_hand_W.f, 1e-4));
  CHECK_THAT(d.F_hand_W.t, IsNear(q.F_hand_W.t, 1e-5));
  CHECK_THAT(d.proxy.X_WT.p, IsNear(q.proxy.X_WT.p, 1e-6));
  CHECK(q.n_pushing >= 3);
  // the hand's and the floor's springs in series, to first order in the tilt
  CHECK(q.F_hand_W.f.z == Approx(800.0 * 8000 / 8800 * 5e-3).epsilon(0.05));
}

TEST_CASE("soft proxy: free space is exactly free for the massless, almost for the others",
          "[servo][trap]") {
  const ContactSet none{};
  SoftProxyState still, dynamic;
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    // 0.2 m/s to and fro
    const double t = 1e-3 * i;
    BodyTick tick = tick_of({{0.05 * std::sin(4 * t), 0, 0}, {}}, &none);
    tick.hand.V_WT.v = {0.2 * std::cos(4 * t), 0, 0};
    const auto q = solve_soft_proxy(model_of(SoftSolver::kQuasiStatic), still, tick);
    REQUIRE(q.F_hand_W == Wrench{});
    const auto d = solve_soft_proxy(model_of(SoftSolver::kPenaltyDynamics), dynamic, tick);
    if (i > 500) most = std::max(most, norm(d.F_hand_W.f));
  }
  // the force that accelerates the proxy: m·a = 0.1 kg · 0.8 m/s²
  CHECK(most == Approx(0.08).epsilon(0.3));
}

TEST_CASE("soft proxy: no point goes further in a tick than the speed limit", "[servo][trap]") {
  const auto solver = GENERATE(SoftSolver::kQuasiStatic, SoftSolver::kPenaltyDynamics);
  const auto touched = GENERATE(size_t{0}, size_t{4});
  const ContactSet set = floor_contacts(touched);
  SoftProxyModel model = model_of(solver);
  model.max_travel = 0.5e-3;
  SoftProxyState state;
  held_at(model, state, {{0, 0, 0.03}, {}}, &set);
  for (int i = 0; i < 200; ++i) {
    const Pose before = state.proxy.X_WT;
    const Pose after =
        held_at(model, state, {{0.02, 0, -0.01}, from_rotation_vector({0.5, 1, 0})}, &set)
            .proxy.X_WT;
    const double turn = norm(to_rotation_vector(after.q * conjugate(before.q)));
    REQUIRE(norm(after.p - before.p) + kUnknownTool.radius * turn <= 0.5e-3 * (1 + 1e-9));
  }
}

TEST_CASE("soft proxy: what is not finite puts it to the hand and renders nothing", "[servo]") {
  ContactSet set = floor_contacts(4);
  set.contacts[2].object_point_O.y = std::nan("");
  SoftProxyState state;
  const Pose X_WT{{0, 0, 0.01}, {}};
  const auto out = held_at(model_of(SoftSolver::kPenaltyDynamics), state, X_WT, &set);
  CHECK_FALSE(out.finite);
  CHECK(out.F_hand_W == Wrench{});
  CHECK(out.proxy.X_WT == X_WT);
}

TEST_CASE("soft proxy: points that approach are braked, those that leave are not",
          "[servo][trap]") {
  // braking viscosity (McNeely et al. 1999); a set computed while the tool came down
  ContactSet set = floor_contacts(4);
  set.trust_radius = 1e-3;
  Mat6 B;
  for (size_t i = 0; i < 3; ++i) B(i, i) = -5;
  set.B = B.a;
  set.X_WT.p = {0, 0, 0.025};
  const auto felt = [&](SoftSolver solver, double speed) {
    SoftProxyState state;
    BodyTick tick = tick_of({{0, 0, 0.025}, {}}, &set);
    tick.hand.V_WT.v.z = speed;
    return solve_soft_proxy(model_of(solver), state, tick);
  };
  // −B v
  CHECK_THAT(felt(SoftSolver::kDirect, -0.1).F_hand_W.f, IsNear({0, 0, 0.5}, 1e-12));
  CHECK(felt(SoftSolver::kDirect, 0.1).F_hand_W == Wrench{});
  const double free_fall = -0.1;
  CHECK(felt(SoftSolver::kPenaltyDynamics, -0.1).proxy.V_WT.v.z > free_fall + 1e-3);
  CHECK(felt(SoftSolver::kQuasiStatic, -0.1).F_hand_W == Wrench{});
}

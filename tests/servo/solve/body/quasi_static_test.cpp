// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/solve/body/quasi_static.h"

#include "tests/support/near.h"
#include "tests/support/rigid.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr QuasiStaticStep kFree{0, 50, 1e-10};

}  // namespace

TEST_CASE("quasi-static: equilibrium of two springs in closed form", "[servo]") {
  // x = (k_T x_h + k p)/(k_T + k), felt k_T (x_h − x)
  const ToolBody tool = kUnknownTool;
  const Coupling coupling{800, 0, 1, 0, 0, 0};
  const SoftContact floor = spring_contact({}, {}, {0, 0, 1}, 3000);
  const Pose X_WT{{0, 0, -5e-3}, {}};
  const auto out = solve_quasi_static(coupling, tool, X_WT, {&floor, 1}, {}, kFree);
  CHECK(out.converged);
  CHECK_THAT(out.X_WP.p, IsNear({0, 0, 800 * -5e-3 / 3800}, 1e-12));
  const Wrench felt = wrench_on_hand(coupling, {X_WT, {}}, {out.X_WP, {}});
  CHECK_THAT(felt.f, IsNear({0, 0, 800.0 * 3000 / 3800 * 5e-3}, 1e-9));
}

TEST_CASE("quasi-static: a hard wall a micrometre ahead of a long step", "[servo][trap]") {
  // the step is 300 times as long as the wall permits
  const ToolBody tool = kUnknownTool;
  const Coupling coupling{1000, 0, 1, 0, 0, 0};
  const double k = GENERATE(3e4, 3e5, 1e6);
  const SoftContact wall = spring_contact({}, {0, 0, -1e-6}, {0, 0, 1}, k);
  const Pose X_WT{{2e-4, 0, -5e-4}, {}};
  const auto out = solve_quasi_static(coupling, tool, X_WT, {&wall, 1}, {}, {5e-4});
  CHECK(out.converged);
  const double z = (1000 * -5e-4 + k * -1e-6) / (1000 + k);
  CHECK_THAT(out.X_WP.p, IsNear({2e-4, 0, z}, 1e-9));
}

TEST_CASE("quasi-static: nothing is left over on random contacts", "[servo]") {
  Random random(4);
  size_t converged = 0;
  const size_t n = trials(400);
  for (size_t i = 0; i < n; ++i) {
    ToolBody tool = kUnknownTool;
    tool.centre_T = 0.02 * random.direction();
    const Coupling coupling{800, 0, 1, 0, 0, 0};
    const Pose X_WT = random.pose(0.05);
    const Pose start = motion_of_centre(tool, {X_WT, {}}).X_WC;
    std::vector<SoftContact> contacts;
    for (size_t k = 0; k < 1 + i % 12; ++k) contacts.push_back(random_contact(random, start));
    const auto out = solve_quasi_static(coupling, tool, X_WT, contacts, X_WT, {2e-3, 50, 1e-8});
    const Pose X_WC = motion_of_centre(tool, {out.X_WP, {}}).X_WC;
    BodyWrench sum = coupling_wrench(coupling, tool, {X_WT, {}}, {X_WC, {}});
    const BodyWrench touch = soft_contact_wrench(contacts, {X_WC, {}});
    const Wrench left = sum.F_W + touch.F_W;
    if (!out.converged) continue;
    ++converged;
    REQUIRE(norm(left.f) <= 1e-7 * (1 + norm(touch.F_W.f)));
    REQUIRE(norm(left.t) <= 1e-7 * (1 + norm(touch.F_W.f)));
    // and it is a minimum: every small motion costs energy
    const double energy = sum.energy + touch.energy;
    for (int k = 0; k < 12; ++k) {
      const Pose aside = moved(X_WC, random_twist(random, 1e-6, 1e-5));
      const double there = coupling_wrench(coupling, tool, {X_WT, {}}, {aside, {}}).energy +
                           soft_contact_wrench(contacts, {aside, {}}).energy;
      REQUIRE(there >= energy * (1 - 1e-12));
    }
  }
  CHECK(converged >= n - n / 50);
}

TEST_CASE("quasi-static: no iteration moves a point further than the trust region", "[servo]") {
  const ToolBody tool = kUnknownTool;
  const Coupling coupling{800, 0, 1, 0, 0, 0};
  const Pose X_WT{{0.1, 0, 0}, from_rotation_vector({0, 0, 1})};
  const SoftContact far = spring_contact({}, {5, 0, 0}, {-1, 0, 0}, 3000);
  const auto out = solve_quasi_static(coupling, tool, X_WT, {&far, 1}, {}, {1e-3, 1, 1e-9});
  CHECK(out.iterations == 1);
  CHECK_FALSE(out.converged);
  CHECK(norm(out.X_WP.p) + tool.radius * norm(to_rotation_vector(out.X_WP.q)) <= 1e-3 * (1 + 1e-9));
}

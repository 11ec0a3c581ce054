// SPDX-License-Identifier: GPL-3.0-or-later
// Renderers of bodies whose contacts are old, in whole sessions.
#include "clients/lab/eval/slow/slow_contact.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("eval slow contact: past an edge nothing is felt, contacts 20 ms old", "[lab][trap]") {
  for (const bool with_box : {false, true}) {
    const SlowScene edge = off_an_edge(with_box);
    for (const JudgedRenderer& renderer : slow_renderers()) {
      const SlowRun fresh = run_slowly(edge, renderer, 1);
      REQUIRE(std::count(fresh.is_felt.begin(), fresh.is_felt.end(), true) > 50);
      CHECK(ghost_ticks(edge, fresh) == 0);
      CHECK(fresh.x.back() > edge.leaves + 0.02);
      const uint32_t stride = kSlowdown > 1 ? 10 : 5;
      for (uint32_t late = 0; late < 20; late += stride) {
        CAPTURE(edge.scene.name, renderer.name, late);
        CHECK(ghost_ticks(edge, run_slowly(edge, renderer, 20, late)) == 0);
      }
    }
  }
}

TEST_CASE("eval slow contact: no sawtooth over a ball at any rate of contact", "[lab][trap]") {
  const SlowScene ball = ball_over_ball(4);
  for (const JudgedRenderer& renderer : slow_renderers()) {
    const SlowRun fresh = run_slowly(ball, renderer, 1);
    const Slowness alone = compare_runs(ball, fresh, fresh);
    CHECK(alone.mean > 0.05);
    for (const uint32_t period : {5u, 10u, 20u}) {
      const Slowness found = compare_runs(ball, fresh, run_slowly(ball, renderer, period));
      CAPTURE(renderer.name, period, alone.rough, found.rough, found.error, found.mean, found.most);
      // stable; where no proxy is solved the hand itself runs into old planes
      const bool is_direct = renderer.solver == SoftSolver::kDirect;
      CHECK(found.most < (is_direct ? 2 : 1.5) * alone.most);
      // old contacts are off by a part of the force, no more
      if (!is_direct) CHECK(found.error < 0.4 * alone.most);
      if (!renderer.is_smooth) continue;
      CHECK(found.rough <= 0.02);
      // a proxy with mass falls behind before contact answers
      if (!renderer.has_mass) CHECK(found.error < 0.25 * alone.mean);
    }
  }
}

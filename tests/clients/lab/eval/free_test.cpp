// SPDX-License-Identifier: GPL-3.0-or-later
// The check of free space, and its result for every renderer.
#include "clients/lab/eval/free.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "clients/lab/support/scripted_hand.h"
#include "clients/lockstep/lockstep.h"
#include "proto/wire/renderer.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("eval free: no renderer without mass is felt where nothing is", "[lab]") {
  FreeEval eval;
  eval.ticks = sweep(80);
  eval.ages = {1, 20};
  eval.all_scenes = false;
  const Rows rows;
  eval_free(eval, rows);
  for (const Row& row : rows.rows()) {
    CAPTURE(row.case_name, row.metric, row.value, row.note);
    CHECK(row.holds.value_or(true));
    // the slaps do reach the object
    if (row.metric == "ticks that may touch, and do") CHECK(row.value > 0);
  }
}

TEST_CASE("eval free: a tool that is given mass is felt, and the judge sees it", "[lab][trap]") {
  const FreeScene scene = peg_over_hole();
  const FreeHand hand = free_hands({0.018, 0, 0.05}, 1)[1];
  FreeWay way(scene, hand, false);
  const FreeFound found =
      judge_free({"", Renderer::kVoxel, SoftSolver::kPenaltyDynamics}, way, 1, 60);
  CHECK(found.free > 50);
  CHECK(found.felt > 50);
}

TEST_CASE("eval free: a tool with mass is felt as torque at the device when it is turned",
          "[lab][trap]") {
  FreeScene scene = peg_over_hole();
  scene.config.proxy.solver = SoftSolver::kPenaltyDynamics;
  scene.config.renderer = Renderer::kVoxel;
  const auto hands = free_hands({0.018, 0, 0.05}, 1);
  const auto shaken = std::find_if(hands.begin(), hands.end(),
                                   [](const FreeHand& hand) { return hand.name == "shaken"; });
  REQUIRE(shaken != hands.end());
  ScriptedHand hand(shaken->path, 1);
  Lockstep session(scene.config, scene.shapes, hand);
  double most = 0;
  for (int k = 0; k < 60; ++k) {
    REQUIRE(session.step());
    most = std::max(most, norm(hand.held.t));
  }
  CHECK(most > 1e-4);
}

TEST_CASE("eval free: the oracle's distances, against closed forms", "[lab]") {
  const FreeOracle boxes(make_box({0.1, 0.1, 0.02}), make_box({0.02, 0.02, 0.02}));
  const auto is_near = [&](const Pose& X, double distance) {
    const double found = boxes.at_least(X, 0, 1);
    CAPTURE(distance, found);
    CHECK(found <= distance * (1 + 1e-12));
    CHECK(found >= 0.89 * distance);
  };
  is_near({{0, 0, 0.05}, {}}, 0.03);
  is_near({{0.1, 0.1, 0.05}, {}}, norm(Vec3{0.04, 0.04, 0.03}));
  // on an edge, then on a corner
  is_near({{0, 0, 0.05}, from_rotation_vector({0.785398163397448, 0, 0})},
          0.04 - 0.01 * std::sqrt(2));
  is_near({{0, 0, 0.4}, {}}, 0.38);
  CHECK(boxes.at_least({{0, 0, 0.05}, {}}, 0, 0.02) == 0.02);
  CHECK(boxes.at_least({{0, 0, 0.05}, {}}, 0.04, 0.1) == 0);
  const FreeOracle point(make_box({0.1, 0.1, 0.02}), {});
  CHECK(point.at_least({{0, 0, 0.05}, {}}, 0, 1) == Approx(0.036));
}

TEST_CASE("eval free: a tick is free by what contact can have known", "[lab]") {
  const FreeScene scene = peg_over_hole();
  // 20 mm above the block, 1 mm a tick to the side
  const FreeHand hand{"to the side", [](double t) { return Pose{{t, 0, 0.06}, {}}; }};
  FreeWay way(scene, hand, false);
  CHECK(way.is_free(0, 0));
  CHECK(way.is_free(0, 10));
  CHECK_FALSE(way.is_free(0, 21));
}

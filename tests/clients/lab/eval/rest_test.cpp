// SPDX-License-Identifier: GPL-3.0-or-later
// Rest positions tested by random segments; the full test is `hapt eval rest`.
#include "clients/lab/eval/rest.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "clients/lab/eval/mesh/renderer.h"
#include "clients/lab/eval/oracle/rest_cgal.h"
#include "clients/lab/support/scripted_hand.h"
#include "contact/shape/baked/mesh_shape.h"
#include "proto/wire/renderer.h"
#include "tests/support/data.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kLeast = 1e-6;  // gain of a segment [m]
constexpr int kDirections = 400;

/// Boxes of 0.1 m, each displaced along x from the previous one.
Soup boxes(int n, double apart) {
  Soup soup;
  for (int i = 0; i < n; ++i) append(soup, make_box({0.1, 0.1, 0.1}), {i * apart, 0, 0});
  return soup;
}

bool has_answer(const Soup& soup, double size) {
  const TemporaryFolder folder;
  RendererEval eval;
  eval.mesh = folder.path() + "/boxes.off";
  eval.size = size;
  eval.ticks = 20;
  std::ofstream(eval.mesh) << as_off(soup);
  const Rows judged;
  eval_renderer(eval, judged);
  const std::vector<Row>& rows = judged.rows();
  const auto has = [&](const auto& is_it) { return std::any_of(rows.begin(), rows.end(), is_it); };
  const bool is_open = has([](const Row& row) { return row.metric == kNoAnswer; });
  const bool is_scored = has([](const Row& row) {
    return row.metric == "ticks not in a local minimum" && row.holds.has_value();
  });
  CHECK(is_scored != is_open);
  return !is_open;
}

}  // namespace

TEST_CASE("rest: ways from a place that holds, beside one, and inside", "[lab]") {
  const MeshShapeData box = build_shape(boxes(1, 0));
  const WayJudge judge(box.view().mesh);
  const Vec3 tool{0.01, 0.02, 0.04}, foot{0.01, 0.02, 0.05};
  CHECK_FALSE(judge.free_way(foot, tool, kLeast, kDirections, 1));
  const std::optional<double> aside =
      judge.free_way(foot + Vec3{2e-3, 0, 0}, tool, kLeast, kDirections, 1);
  REQUIRE(aside);
  // gain of the way back to the foot of the perpendicular
  const double most = std::hypot(0.01, 2e-3) - 0.01;
  CHECK(*aside <= most);
  CHECK(*aside > 0.5 * most);
  CHECK(judge.holds(tool));
  CHECK_FALSE(judge.holds(foot + Vec3{0, 0, 1e-12}));
  CHECK_FALSE(judge.is_free(tool, {0.01, 0.02, 0.045}));
  CHECK_FALSE(judge.is_free(foot + Vec3{0, 0, 0.01}, tool));
}

TEST_CASE("rest: no point is caught at a vertex of a spiky mesh", "[lab][trap]") {
  RestEval eval;
  // a hand needs a second to go to and fro
  eval.ticks = std::max<uint64_t>(sweep(3000), 1000);
  const RestHand hand = GENERATE(RestHand::kReach, RestHand::kSlap);
  const RestCount count = judge_rests(make_spiky_sphere(6, 0.6, 19), hand, 0, eval, 19);
  CAPTURE(name_of(hand), count.worst, count.of_force);
  CHECK(count.judged > eval.ticks / 30);
  CHECK(count.caught == 0);
  CHECK(count.inside == 0);
  CHECK(count.restless == 0);
  CHECK(count.limits == 0);
}

TEST_CASE("rest: a sphere that rolls among many edges rests within its tick", "[lab][trap]") {
  RestEval eval;
  eval.ticks = std::max<uint64_t>(sweep(2000), 500);
  const RestHand hand = GENERATE(RestHand::kSlap, RestHand::kCreep);
  const Soup mesh = make_spiky_sphere(40, 0.05, 1);
  const RestCount count = judge_rests(mesh, hand, 0.01, eval, 1);
  CAPTURE(name_of(hand));
  CHECK(count.touching > eval.ticks / 4);
  CHECK(count.restless == 0);
  CHECK(count.limits == 0);
}

TEST_CASE("eval: a closed mesh that cuts itself has no answer", "[lab]") {
  CHECK(has_answer(boxes(1, 0), 0.1));
  CHECK(has_answer(boxes(2, 0.15), 0.25));
  CHECK_FALSE(has_answer(boxes(2, 0.05), 0.15));
}

TEST_CASE("eval: a tool that overlaps where it starts has no answer", "[lab]") {
  const MeshShapeData box = build_shape(boxes(1, 0));
  SessionConfig config = plain_session(1000);
  config.renderer = Renderer::kVirtualProxy3;
  config.proxy_radius = 0.02;
  for (const double height : {0.0, 0.06, 0.08}) {
    ScriptedHand hand([&](double) { return Vec3{0, 0, height}; });
    const EvalJudge judge = judge_run(config, box.view(), hand, {1, 0}, 2);
    CHECK(judge.began_overlapping() == (height < 0.07));
  }
}

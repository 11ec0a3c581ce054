// SPDX-License-Identifier: GPL-3.0-or-later
// The goals of the point renderer on the benchmark set, on short parts of the paths; the whole
// paths are a command (docs/benchmarks).
#include "clients/lab/eval/mesh/renderer.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "clients/lab/eval/mesh/friction.h"
#include "clients/lab/eval/mesh/table.h"
#include "clients/lab/support/scripted_hand.h"
#include "proto/wire/renderer.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"
#include "tests/support/tolerance.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kRenderedStiffness = 1000;

struct Run {
  LockstepOptions lockstep;
  uint64_t ticks;
  double radius = 0;  // 0: the god-object [m]
};

EvalJudge judge_work(const std::string& name, const Run& run) {
  EvalWork work = make_eval_work(name, run.radius);
  const MeshShapeData mesh = build_shape(std::move(work.soup));
  ScriptedHand hand(work.path);
  SessionConfig config = plain_session(kRenderedStiffness);
  if (run.radius > 0) config.renderer = Renderer::kVirtualProxy3;
  config.proxy_radius = run.radius;
  return judge_run(config, mesh.view(), hand, run.lockstep, run.ticks);
}

void check_whole(const EvalJudge& judge, uint64_t ticks) {
  CHECK(judge.found().ticks == ticks);
  CHECK(judge.found().jammed == 0);
  CHECK(judge.found().lost == 0);
  CHECK(judge.found().not_finite == 0);
  CHECK(judge.found().deepest_behind == 0);
}

}  // namespace

TEST_CASE("eval: no jam, no fall-through, the exact force in lockstep", "[lab][trap]") {
  const std::string name = GENERATE("hf:50", "hf:187", "sphere:16", "sphere:59");
  const double radius = GENERATE(0.0, 1e-3, 5e-3);
  const uint64_t ticks = trials(radius > 0 ? 1500 : 3000) + 600;
  const EvalJudge judge = judge_work(name, {{1, 0}, ticks, radius});
  CAPTURE(name, radius, judge.found().worst_tick);
  check_whole(judge, ticks);
  CHECK(judge.found().worst_error <= tol(1e-6));
  if (radius > 0) {
    CHECK(judge.found().not_minimal == 0);
  } else {
    CHECK(judge.found().touching > ticks - 600);
  }
}

TEST_CASE("eval: one tick of latency costs at most 0.02 N rms", "[lab]") {
  const std::string name = GENERATE("hf:50", "sphere:16");
  const double radius = GENERATE(0.0, 1e-3, 5e-3);
  const uint64_t ticks = trials(3000) + 600;
  const EvalJudge judge = judge_work(name, {{1, 1}, ticks, radius});
  CAPTURE(name, radius, judge.found().worst_tick);
  check_whole(judge, ticks);
  CHECK(judge.rms_error() <= tol(0.02));
}

TEST_CASE("eval: no ripple on the flat slide", "[lab][trap]") {
  const uint32_t latency = GENERATE(0u, 1u);
  const EvalJudge judge = judge_work("flat:50", {{1, latency}, 2000});
  CHECK(judge.found().worst_ripple <= tol(1e-5));
  CHECK(judge.found().worst_error <= tol(1e-6));
}

TEST_CASE("eval: scanned and broken meshes never give NaN, never more than the limit", "[lab]") {
  const std::string name = GENERATE("bunny00.off", "refined_elephant.off", "armadillo.off",
                                    "femur.off", "bones.off", "pig.stl", "mannequin-devil.off");
  const auto path = find_mesh(name);
  // the largest meshes take a minute to check under sanitizers
  if (!path || (kSlowdown > 1 && name != "bones.off" && name != "pig.stl")) return;
  CAPTURE(name);
  const BakedShape mesh = bake_scan(*path, 0.15);
  const uint64_t ticks = trials(3000) + 600;
  ScriptedHand hand(way_around(mesh.shape, 0, ticks));
  SessionConfig config = plain_session(kRenderedStiffness);
  config.safety.max_force = 6;
  const EvalJudge judge = judge_run(config, mesh.shape, hand, {1, 0}, ticks);
  CHECK(judge.found().not_finite == 0);
  CHECK(judge.found().jammed == 0);
  CHECK(judge.found().largest_held <= 6 * (1 + 1e-12));
  // sanitizers leave no time to reach every surface
  if (kSlowdown == 1) CHECK(judge.found().touching > 0);
}

TEST_CASE("eval: a sphere on scanned and broken meshes: no NaN, no more than the limit", "[lab]") {
  const double radius = GENERATE(1e-3, 5e-3);
  const std::string name = GENERATE("bunny00.off", "refined_elephant.off", "armadillo.off",
                                    "femur.off", "bones.off", "mannequin-devil.off");
  Soup soup = load_off(name, 0.15);
  if (soup.triangles.empty()) return;
  CAPTURE(name, radius);
  const MeshShapeData mesh = build_shape(std::move(soup));
  const uint64_t ticks = trials(500) + 600;
  ScriptedHand hand(way_around(mesh.view(), radius, ticks));
  SessionConfig config = plain_session(kRenderedStiffness);
  config.safety.max_force = 6;
  config.renderer = Renderer::kVirtualProxy3;
  config.proxy_radius = radius;
  const MeshShape shape = mesh.view();
  Lockstep lockstep(config, std::span(&shape, 1), hand, {1, 0});
  for (uint64_t k = 0; k < ticks; ++k) {
    REQUIRE(lockstep.step());
    const ServoFrame& f = lockstep.frame();
    REQUIRE((is_finite(f.F_coupling_W.f) && is_finite(f.F_device_B) && is_finite(f.X_WG)));
    REQUIRE(norm(f.F_device_B.f) <= 6 * (1 + 1e-12));
  }
}

TEST_CASE("eval: a slide that is cut short is held where it ended, never let go", "[lab][trap]") {
  // deep in a broken mesh there are more facets on the path than one step may try
  Soup soup = load_off("mannequin-devil.off", 0.15);
  if (soup.triangles.empty() || kSlowdown > 1) return;
  const MeshShapeData mesh = build_shape(std::move(soup));
  ScriptedHand hand(way_around(mesh.view(), 0, kEvalTicks));
  const SessionConfig config = plain_session(kRenderedStiffness);
  const MeshShape shape = mesh.view();
  Lockstep lockstep(config, std::span(&shape, 1), hand, {1, 0});
  int cut_short = 0;
  for (int k = 0; k < kEvalTicks; ++k) {
    REQUIRE(lockstep.step());
    if ((lockstep.contacts()->flags & kContactIterationLimit) == 0) continue;
    ++cut_short;
    const ServoFrame& f = lockstep.frame();
    // the servo's answer is one slide ahead of the verified proxy, a little nearer to the tool
    REQUIRE(norm(f.F_coupling_W.f) >= 0.9 * kRenderedStiffness * norm(f.X_WG.p - f.X_WT.p));
  }
  CHECK(cut_short > 0);
}

TEST_CASE(
    "eval: the judge sees a jam, a fall-through, NaN and a proxy behind the surface or not at rest",
    "[lab][property]") {
  OracleAnswer truth;
  ServoFrame frame{};
  EvalJudge judge(kRenderedStiffness);
  for (int k = 0; k < 10; ++k) {
    // the tool slides under the plane z = 0, 1 mm deep
    frame.tick = static_cast<uint64_t>(k);
    frame.X_WT.p = {1e-4 * k, 0, -1e-3};
    truth.proxy_O = {1e-4 * k, 0, 0};
    frame.X_WP.p = truth.proxy_O;
    // the proxy stays from tick 4 on; its force exceeds the limit of 0.1 N from 0.46 mm on
    if (k >= 4) frame.X_WP.p = {4e-4, 0, 0};
    frame.F_coupling_W.f = kRenderedStiffness * (frame.X_WP.p - frame.X_WT.p);
    judge.add(frame, 0, truth, {});
  }
  CHECK(judge.found().jammed == 1);
  CHECK(judge.found().lost == 0);
  CHECK(judge.found().worst_error == Approx(0.5));
  frame.F_coupling_W.f = {};
  judge.add(frame, 0, truth, {{2e-3, true}, 3e-9});
  CHECK(judge.found().lost == 1);
  CHECK(judge.found().deepest_behind == 2e-3);
  CHECK(judge.found().not_minimal == 1);
  frame.F_coupling_W.f.x = std::nan("");
  judge.add(frame, 0, truth, {});
  CHECK(judge.found().not_finite == 1);
}

TEST_CASE("eval: friction on the plane is within 1 % of its ratio while it slides", "[lab]") {
  const double ratio = GENERATE(0.1, 0.5, 1.0);
  const double radius = GENERATE(0.0, 1e-3);
  EvalWork work = make_eval_work("flat:50", radius);
  const MeshShapeData mesh = build_shape(std::move(work.soup));
  ScriptedHand hand(work.path);
  SessionConfig config = plain_session(kRenderedStiffness);
  config.renderer = Renderer::kVirtualProxy3;
  config.proxy_radius = radius;
  config.objects[0].material.friction_static = ratio;
  config.objects[0].material.friction_dynamic = ratio;
  FrictionJudge friction(ratio, {0, 0, 1});
  judge_run(config, mesh.view(), hand, {1, 0}, 2000,
            [&](const ServoFrame& frame) { friction.add(frame); });
  CHECK(friction.sliding() > 1000);
  CHECK(friction.worst() <= tol(0.01));
}

TEST_CASE("eval: many cases in one go, mesh by mesh", "[lab]") {
  EvalTable table;
  table.meshes = {"hf:7", "all"};
  table.radii = {0, 1e-3};
  table.latencies = {0, 1};
  const std::vector<RendererEval> cases = cases_of(table);
  REQUIRE(cases.size() == 4 * (1 + published_work().size()));
  CHECK(cases[0].mesh == "hf:7");
  CHECK(cases[1].lockstep.contact_latency == 1);
  CHECK(cases[2].radius == 1e-3);
  CHECK(cases[4].mesh == published_work()[0]);
}

TEST_CASE("eval: where legs take turns a sphere settles on the planes of all of them",
          "[lab][trap]") {
  // part of hf:742 at tick 17416: two places 80 nm apart, equally near within the stand-off
  constexpr double kRadius = 5e-3, kAround = 12e-3;
  constexpr uint64_t kFirst = 17300;
  const EvalWork work = make_eval_work("hf:742", kRadius);
  const Vec3 at = work.path(17.416);
  Soup near{work.soup.vertices, {}};
  for (const Triangle& t : work.soup.triangles) {
    const Vec3 d = work.soup.vertices[t[0]] - at;
    if (std::hypot(d.x, d.y) < kAround) near.triangles.push_back(t);
  }
  const MeshShapeData mesh = build_shape(std::move(near));
  ScriptedHand hand([&](double t) {
    // first down from above, then along the benchmark path
    const double above = t < 0.05 ? 10e-3 * (1 - t / 0.05) : 0;
    return work.path(1e-3 * kFirst + t) + Vec3{0, 0, above};
  });
  SessionConfig config = plain_session(kRenderedStiffness);
  config.renderer = Renderer::kVirtualProxy3;
  config.proxy_radius = kRadius;
  const EvalJudge judge = judge_run(config, mesh.view(), hand, {1, 0}, 150);
  CAPTURE(judge.found().worst_tick);
  CHECK(judge.found().worst_error <= tol(1e-6));
  CHECK(judge.found().not_minimal == 0);
}

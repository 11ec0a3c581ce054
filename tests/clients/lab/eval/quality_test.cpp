// SPDX-License-Identifier: GPL-3.0-or-later
// The checks of the quality scenes against answers that are right or wrong by construction, and a
// short form of each scene.
#include "clients/lab/eval/quality.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "clients/lab/eval/drag.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using haptic::test::TemporaryFolder;

namespace {

constexpr size_t kSamples = 24;
constexpr QualityGrain kCoarse{kSamples, 1, 1e-3, 0.8e-3};

/// The symmetric answer, with a stiffness of 10 kN/m.
Wrench ideal(QualityScene scene, const Pose& X_WT) {
  constexpr double kQualityStiffness = 1e4;
  const Vec3 axis = rotate(X_WT.q, {0, 0, 1});
  const Vec3 aside{X_WT.p.x, X_WT.p.y, 0};
  switch (scene) {
    case QualityScene::kConeOnPlane:
      return {{0, 0, kQualityStiffness * kQualityDepth}, {}};
    case QualityScene::kSphereRoundCylinder:
      return {kQualityStiffness * kQualityDepth * normalized(aside), {}};
    case QualityScene::kCubeOnPlate:
      return {{0, 0, kQualityStiffness * kQualityDepth}, cross(axis, Vec3{0, 0, 1})};
    case QualityScene::kPegInHole:
      break;
  }
  const double beyond = std::max(norm(aside) - kPegClearance, 0.0);
  if (beyond > 0) return {-kQualityStiffness * beyond * normalized(aside), {}};
  return {{}, cross(axis, Vec3{0, 0, 1})};
}

std::vector<Row> judged_quality(QualityScene scene, const WrenchAt& wrench_at) {
  const Rows rows;
  judge_quality(scene, wrench_at, kSamples, {}, "judge", rows);
  return rows.rows();
}

/// Number of goals missed by a falsified answer.
template <class Falsify>
size_t missed(QualityScene scene, const Falsify& falsify) {
  size_t n = 0;
  const auto wrong = [&](const Pose& X_WT) { return falsify(ideal(scene, X_WT), X_WT, n++); };
  const std::vector<Row> rows = judged_quality(scene, wrong);
  return static_cast<size_t>(
      std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.holds == false; }));
}

double figure(const std::vector<Row>& rows, const std::string& metric) {
  const auto is_it = [&](const Row& row) { return row.metric == metric; };
  const auto row = std::find_if(rows.begin(), rows.end(), is_it);
  REQUIRE(row != rows.end());
  return row->value;
}

std::vector<Row> short_form(QualityScene scene, size_t renderer) {
  const test::TemporaryCache cache;
  const QualityShapes shapes = bake_quality(scene, kCoarse);
  const Rows rows;
  eval_quality(scene, quality_renderers()[renderer], shapes, kCoarse, rows);
  return rows.rows();
}

constexpr size_t kDirect6 = 0, kFieldDirect = 1, kFieldQuasiStatic = 2;

}  // namespace

TEST_CASE("eval quality: what symmetry demands holds every goal", "[lab]") {
  const auto scene = GENERATE(QualityScene::kConeOnPlane, QualityScene::kSphereRoundCylinder,
                              QualityScene::kCubeOnPlate, QualityScene::kPegInHole);
  const std::vector<Row> rows =
      judged_quality(scene, [&](const Pose& X_WT) { return ideal(scene, X_WT); });
  CHECK(all_hold(rows));
  CHECK(std::count_if(rows.begin(), rows.end(), [](const Row& r) { return r.goal.has_value(); }) >=
        2);
}

TEST_CASE("eval quality: a wrong force misses the goals", "[lab]") {
  const Quat leans = from_rotation_vector({0.05, 0, 0});
  const auto leaning = [&](Wrench F, const Pose&, size_t) {
    F.f = rotate(leans, F.f);
    return F;
  };
  CHECK(missed(QualityScene::kConeOnPlane, leaning) == 2);
  CHECK(missed(QualityScene::kSphereRoundCylinder, leaning) == 1);
  const auto uneven = [](Wrench F, const Pose&, size_t i) {
    F.f *= i % 2 == 0 ? 1.05 : 0.95;
    return F;
  };
  CHECK(missed(QualityScene::kConeOnPlane, uneven) == 1);
  CHECK(missed(QualityScene::kSphereRoundCylinder, uneven) == 1);
  const auto twisted = [](Wrench F, const Pose&, size_t) {
    F.t += Vec3{2e-3, 1e-3, 0} * norm(F.f);
    return F;
  };
  CHECK(missed(QualityScene::kSphereRoundCylinder, twisted) == 1);
  CHECK(missed(QualityScene::kCubeOnPlate, twisted) == 2);
  const auto drags_in = [](Wrench F, const Pose&, size_t) { return F + Wrench{{0, 0, 1e-3}, {}}; };
  CHECK(missed(QualityScene::kPegInHole, drags_in) == 2);
  const auto tips_over = [](const Wrench& F, const Pose&, size_t) { return Wrench{F.f, -F.t}; };
  CHECK(missed(QualityScene::kPegInHole, tips_over) == 1);
  const auto hardens = [](Wrench F, const Pose&, size_t) {
    F.f *= norm_squared(F.f);
    return F;
  };
  CHECK(missed(QualityScene::kPegInHole, hardens) == 1);
  const auto nothing = [](const Wrench&, const Pose&, size_t) { return Wrench{}; };
  CHECK(missed(QualityScene::kConeOnPlane, nothing) >= 1);
  CHECK(missed(QualityScene::kSphereRoundCylinder, nothing) >= 1);
  CHECK(missed(QualityScene::kCubeOnPlate, nothing) >= 1);
  CHECK(missed(QualityScene::kPegInHole, nothing) >= 1);
}

TEST_CASE("eval quality: noise is what a moving average leaves", "[lab]") {
  const auto rows = judged_quality(QualityScene::kConeOnPlane, [n = 0](const Pose&) mutable {
    return Wrench{{0, 0, ++n % 2 == 0 ? 1.01 : 0.99}, {}};
  });
  // the moving average contains 1/21 of the last sample
  CHECK(figure(rows, "noise") == Approx(0.01).epsilon(0.06));
}

TEST_CASE("eval quality: a cone slid along a plane, a cube turned on a plate", "[lab]") {
  const size_t renderer = GENERATE(kFieldDirect + 0, kFieldQuasiStatic + 0);
  const QualityScene scene = GENERATE(QualityScene::kConeOnPlane, QualityScene::kCubeOnPlate);
  CHECK(all_hold(short_form(scene, renderer)));
}

TEST_CASE("eval quality: a cone slid along a plane, triangles against triangles", "[lab]") {
  const std::vector<Row> rows = short_form(QualityScene::kConeOnPlane, kDirect6);
  // 64 steps around
  CHECK(figure(rows, "direction off the normal, max") <= 3);
  CHECK(figure(rows, "tangential/normal force, max") <= 0.06);
  CHECK(figure(rows, "force, std/mean") <= 0.1);
}

TEST_CASE("eval quality: a sphere led round a cylinder", "[lab]") {
  const std::vector<Row> rows = short_form(QualityScene::kSphereRoundCylinder, kFieldQuasiStatic);
  CHECK(figure(rows, "direction off the radius, rms") <= 2);
  // cells of 1 mm, facets of 1.4 mm
  CHECK(figure(rows, "torque about the centre/(force · radius), max") <= 0.02);
  CHECK(figure(rows, "force, peak to peak/mean") <= 0.1);
}

TEST_CASE("eval quality: a peg in its hole", "[lab]") {
  const std::vector<Row> rows = short_form(QualityScene::kPegInHole, kFieldDirect);
  CHECK(figure(rows, "centred: force") == 0);
  CHECK(figure(rows, "aside: R² of force over e − c") >= 0.99);
  CHECK(figure(rows, "tilted: places where the couple does not turn back") == 0);
}

TEST_CASE("eval quality: drag in free space is the mass times its acceleration, in closed form",
          "[lab]") {
  for (const double mass : {0.01, 0.1, 1.0}) {
    for (const double frequency : {0.5, 2.0, 6.0}) {
      SoftProxyModel model;
      model.solver = SoftSolver::kPenaltyDynamics;
      BodyTick tick;
      tick.tool.mass = mass;
      tick.coupling = {800, 5, 1, 1e-3, 0, 0};
      const FreeMotion motion{.turning = 0, .frequency = frequency};
      CAPTURE(mass, frequency);
      CHECK(free_space_drag(model, tick, motion) ==
            Approx(drag_in_closed_form(tick, motion)).epsilon(0.05));
      for (const SoftSolver solver : {SoftSolver::kQuasiStatic, SoftSolver::kDirect}) {
        model.solver = solver;
        CHECK(free_space_drag(model, tick, {.frequency = frequency}) == 0);
      }
    }
  }
}

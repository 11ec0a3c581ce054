// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/ruffaldi.h"

#include <catch2/catch.hpp>

#include "clients/lab/eval/mesh/renderer.h"
#include "tests/support/hostile_text.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"

using namespace haptic;
using namespace haptic::test;

namespace {

std::string error_of(const std::string& text) {
  return refusal<TrajError>([&] { parse_traj(text, "probe.traj"); });
}

}  // namespace

TEST_CASE("traj: seven or six numbers a line, comments and commas", "[lab]") {
  const auto seven = parse_traj("# t x y z f\n\n0 1 2 3 4 5 6\n0.002,1,2,3, 7 8 9 # end\r\n", "a");
  REQUIRE(seven.size() == 2);
  CHECK(seven[1].t == 0.002);
  CHECK(seven[0].p_O == Vec3{1, 2, 3});
  CHECK(seven[1].force_O == Vec3{7, 8, 9});
  const auto six = parse_traj("1 2 3 4 5 6\n1 2 3 4 5 6", "a");
  CHECK(six[1].t == 0.001);
  // read to the last bit
  const auto again = parse_traj("0.1 0.33333333333333331 -2e-9 3e5 1e-300 0 -0.1", "a");
  CHECK(again[0].p_O == Vec3{1.0 / 3, -2e-9, 3e5});
  CHECK(again[0].force_O == Vec3{1e-300, 0, -0.1});
}

TEST_CASE("traj: what is wrong is said with its line", "[lab]") {
  CHECK(error_of("0 1 2 3 4 5 6\n0 1 2 3 4 5 6").rfind("probe.traj:2: time does not grow", 0) == 0);
  CHECK(error_of("1 2 3 4 5").rfind("probe.traj:1: only 5 numbers", 0) == 0);
  CHECK(error_of("1 2 3 4 5 6\n0 1 2 3 4 5 6").rfind("probe.traj:2: not as many", 0) == 0);
  CHECK(error_of("1 2 3 4 5 6 7 8").rfind("probe.traj:1: more than seven", 0) == 0);
  for (const char* text : {"1 2 3 4 5 x", "1 2 3 4 5 6x", "1 2 3 4 5 nan", "1 2 3 4 5 inf"}) {
    CHECK(error_of(text).rfind("probe.traj:1: not a number", 0) == 0);
  }
  CHECK(error_of("# nothing\n").rfind("probe.traj:1: no samples", 0) == 0);
}

TEST_CASE("traj: resampled to 1 kHz, straight in between", "[lab]") {
  const auto samples = at_one_kilohertz(
      {{1.0, {0, 0, 0}, {0, 0, 1}}, {1.004, {4, 0, 0}, {0, 0, 5}}, {1.006, {4, 2, 0}, {}}});
  REQUIRE(samples.size() == 7);
  CHECK_THAT(samples[1].p_O, IsNear({1, 0, 0}, 1e-9));
  CHECK_THAT(samples[3].force_O, IsNear({0, 0, 4}, 1e-9));
  CHECK_THAT(samples[5].p_O, IsNear({4, 1, 0}, 1e-9));
}

TEST_CASE("ruffaldi: a known error, lag and jump are found", "[lab]") {
  std::vector<TrajSample> probe;
  std::vector<Vec3> rendered;
  for (int k = 0; k < 1000; ++k) {
    const auto force = [](int i) { return Vec3{0, 0, 2 + std::sin(0.05 * i)}; };
    probe.push_back({1e-3 * k, {}, force(k)});
    rendered.push_back(force(std::max(k - 3, 0)));
  }
  const ForceComparison late = compare_forces(probe, rendered);
  CHECK(late.lag == 3);
  CHECK(late.rms_aligned < 0.1 * late.rms);
  CHECK(late.direction_jump == 0);
  for (size_t k = 0; k < probe.size(); ++k) rendered[k] = probe[k].force_O + Vec3{0.3, 0, 0.4};
  const ForceComparison off = compare_forces(probe, rendered);
  CHECK(off.rms == Approx(0.5));
  CHECK(off.rms_normal == Approx(0.4));
  CHECK(off.rms_tangential == Approx(0.3));
  CHECK(off.max == Approx(0.5));
}

TEST_CASE("ruffaldi: half a percent of the mean force on plane and sphere", "[lab]") {
  const std::string surface = GENERATE("plane", "sphere");
  // a third of a million triangles: not under sanitizers
  if (kSlowdown > 1 && surface != "plane") return;
  RuffaldiWork work = make_ruffaldi_work(surface, 2000);
  const MeshShapeData mesh = build_shape(std::move(work.soup));
  add_noise(work.in_trajectory, 1e-5);
  const auto forces = render_trajectory(mesh.view(), work.in_trajectory, {});
  const ForceComparison c = compare_forces(work.probe, forces);
  CHECK(c.samples > 1500);
  CHECK(c.rms <= tol(0.005) * c.mean_force);
  CHECK(c.lag == 0);
}

TEST_CASE("ruffaldi: without noise the error is that of the mesh", "[lab]") {
  const std::string surface = GENERATE("plane", "bumpy");
  if (kSlowdown > 1 && surface != "plane") return;
  RuffaldiWork work = make_ruffaldi_work(surface, 1500);
  const MeshShapeData mesh = build_shape(std::move(work.soup));
  const auto forces = render_trajectory(mesh.view(), work.in_trajectory, {1, 0});
  const ForceComparison c = compare_forces(work.probe, forces);
  CHECK(c.rms_normal <= 2 * work.facet_error + tol(1e-9));
}

TEST_CASE("ruffaldi: a scan of a surface gives its in-trajectory back", "[lab]") {
  const RuffaldiWork work = make_ruffaldi_work("plane", 1500);
  const MeshShapeData mesh = build_shape(work.soup);
  const auto inside = in_trajectory_of(work.probe, mesh.view());
  for (size_t k = 0; k < inside.size(); ++k) {
    if (work.probe[k].force_O == Vec3{}) continue;
    REQUIRE_THAT(inside[k], IsNear(work.in_trajectory[k], 1e-12));
  }
}

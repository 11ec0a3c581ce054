// SPDX-License-Identifier: GPL-3.0-or-later
// The oracle against closed forms only: it checks the renderers, so they cannot check it.
#include "clients/eval/oracle/oracle.h"

#include "clients/eval/oracle/rest_cgal.h"
#include "clients/eval/scenes/workload.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kExact = 1e-14;  // [m]

/// Two walls and a floor that meet at the origin, seen from the positive octant.
haptic::Soup make_corner() {
  haptic::Soup soup;
  constexpr double kFar = 0.05;
  soup.vertices = {{0, 0, 0},    {kFar, 0, 0},    {kFar, kFar, 0}, {0, kFar, 0},
                   {0, 0, kFar}, {kFar, 0, kFar}, {0, kFar, kFar}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 5}, {0, 5, 1}, {0, 3, 6}, {0, 6, 4}};
  return soup;
}

}  // namespace

TEST_CASE("eval oracle: on the plane it is the foot of the tool, to the last digits", "[lab]") {
  const MeshShapeData plane = haptic::build_shape(haptic::make_grid(0.1, 50));
  const FacetBins facets(plane.view().mesh);
  GodObjectOracle oracle(facets);
  oracle.seed(haptic::flat_slide(0));
  int touching = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 tool = haptic::flat_slide(1e-3 * k);
    const OracleAnswer answer = oracle.follow(tool);
    REQUIRE(answer.converged);
    const Vec3 foot{tool.x, tool.y, std::max(tool.z, 0.0)};
    REQUIRE(norm(answer.proxy_O - foot) <= kExact);
    touching += answer.n_active;
  }
  CHECK(touching > 1500);
}

TEST_CASE("eval oracle: a corner of one, two and three planes", "[lab]") {
  const MeshShapeData corner = haptic::build_shape(make_corner());
  const FacetBins facets(corner.view().mesh);
  GodObjectOracle oracle(facets);
  struct Case {
    Vec3 tool, proxy;
    int n_active;
  };
  const std::vector<Case> cases{{{0.01, 0.02, -0.003}, {0.01, 0.02, 0}, 1},
                                {{-0.001, 0.02, -0.003}, {0, 0.02, 0}, 2},
                                {{-0.001, -0.002, 0.003}, {0, 0, 0.003}, 2},
                                {{-0.001, -0.002, -0.003}, {0, 0, 0}, 3},
                                {{0.01, -0.002, 0.003}, {0.01, 0, 0.003}, 1},
                                {{0.01, 0.002, 0.003}, {0.01, 0.002, 0.003}, 0}};
  oracle.seed({0.01, 0.01, 0.01});
  for (const Case& c : cases) {
    CAPTURE(c.tool);
    const OracleAnswer answer = oracle.follow(c.tool);
    CHECK(answer.converged);
    CHECK(answer.n_active == c.n_active);
    CHECK(norm(answer.proxy_O - c.proxy) <= kExact);
  }
}

TEST_CASE("eval oracle: on a sphere it is the foot within the facets' sagitta", "[lab]") {
  constexpr double kRadius = 0.05;
  const MeshShapeData sphere = haptic::build_shape(haptic::make_icosphere(kRadius, 5));
  double sagitta = 0, longest = 0;
  for (const auto& [a, b, c] : sphere.mesh.triangles) {
    const auto& v = sphere.mesh.vertices;
    sagitta = std::max(sagitta, kRadius - norm((v[a] + v[b] + v[c]) / 3.0));
    longest = std::max({longest, norm(v[a] - v[b]), norm(v[b] - v[c]), norm(v[c] - v[a])});
  }
  const FacetBins facets(sphere.view().mesh);
  GodObjectOracle oracle(facets);
  oracle.seed((kRadius + 1e-3) * haptic::sphere_direction(0));
  for (int k = 0; k < 500; ++k) {
    const Vec3 u = haptic::sphere_direction(1e-3 * k);
    const OracleAnswer answer = oracle.follow((kRadius - 1e-3) * u);
    REQUIRE(answer.converged);
    REQUIRE(norm(answer.proxy_O) <= kRadius);
    REQUIRE(norm(answer.proxy_O) >= kRadius - 2 * sagitta);
    REQUIRE(norm(answer.proxy_O - kRadius * u) <= longest);
  }
}

TEST_CASE("eval oracle: a thin plate holds it on its own side", "[lab][trap]") {
  const MeshShapeData plate = haptic::build_shape(haptic::make_box({0.1, 0.1, 1e-4}));
  const FacetBins facets(plate.view().mesh);
  GodObjectOracle oracle(facets);
  oracle.seed({0, 0, 1e-3});
  const OracleAnswer answer = oracle.follow({0.01, 0.02, -0.04});
  CHECK(norm(answer.proxy_O - Vec3{0.01, 0.02, 0.5e-4}) <= kExact);
}

TEST_CASE("eval oracle: where it has left a saddle vertex no straight way leads nearer", "[lab]") {
  const MeshShapeData sphere = haptic::build_shape(haptic::make_bumpy_sphere(118));
  const FacetBins facets(sphere.view().mesh);
  const WayJudge ways(sphere.view().mesh);
  GodObjectOracle oracle(facets);
  oracle.seed(haptic::sphere_slide(0, 0));
  constexpr double kLeastGain = 1e-6;  // [m]
  constexpr int kDirections = 2000;
  int left = 0;
  for (uint64_t k = 0; k < 20000; ++k) {
    const Vec3 tool = haptic::sphere_slide(1e-3 * static_cast<double>(k), 0);
    const OracleAnswer answer = oracle.follow(tool);
    if (!answer.has_left) continue;
    ++left;
    CAPTURE(k, answer.n_active, norm(answer.proxy_O - tool));
    CHECK_FALSE(ways.free_way(answer.proxy_O, tool, kLeastGain, kDirections, k).found);
  }
  CHECK(left > 0);
}

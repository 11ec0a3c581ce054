// SPDX-License-Identifier: GPL-3.0-or-later
// The sphere oracle against closed forms only: it checks the renderers, so they cannot check it.
#include "clients/eval/oracle/sphere_oracle.h"

#include "clients/eval/oracle/place.h"
#include "clients/eval/scenes/workload.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kExact = 1e-12;  // [m]

/// An oracle with its mesh.
struct Lab {
  Lab(haptic::Soup soup, double radius)
      : made(haptic::build_shape(std::move(soup))),
        facets(made.view().mesh),
        oracle(facets, radius) {}

  MeshShapeData made;
  FacetBins facets;
  SphereOracle oracle;
};

}  // namespace

TEST_CASE("sphere oracle: on the plane it is the foot of the tool, a radius higher", "[lab]") {
  const double radius = GENERATE(1e-3, 5e-3);
  Lab lab(haptic::make_grid(0.1, 50), radius);
  lab.oracle.seed(haptic::flat_slide(0) + Vec3{0, 0, radius});
  for (int k = 0; k < 2000; ++k) {
    const Vec3 tool = haptic::flat_slide(1e-3 * k) + Vec3{0, 0, radius};
    const OracleAnswer answer = lab.oracle.follow(tool);
    REQUIRE(answer.converged);
    const Vec3 foot{tool.x, tool.y, std::max(tool.z, radius)};
    REQUIRE(norm(answer.proxy_O - foot) <= tol(kExact));
  }
}

TEST_CASE("sphere oracle: a fillet of its radius in a corner of one, two and three walls",
          "[lab][trap]") {
  constexpr double kRadius = 2e-3;
  // walls x = 0, y = 0, z = 0 seen from the positive octant: a box inside out
  haptic::Soup soup = haptic::test::turned_inside_out(haptic::make_box({0.2, 0.2, 0.2}));
  for (Vec3& v : soup.vertices) v += {0.1, 0.1, 0.1};
  Lab lab(std::move(soup), kRadius);
  lab.oracle.seed({0.01, 0.01, 0.01});
  struct Case {
    Vec3 tool, proxy;
    int n_active;
  };
  const std::vector<Case> cases{{{0.01, 0.02, -1e-3}, {0.01, 0.02, kRadius}, 1},
                                {{-1e-3, 0.02, -3e-3}, {kRadius, 0.02, kRadius}, 2},
                                {{-1e-3, 1e-3, 1e-3}, {kRadius, kRadius, kRadius}, 3},
                                {{0.01, 1e-3, 0.003}, {0.01, kRadius, 0.003}, 1},
                                {{0.01, 0.003, 0.003}, {0.01, 0.003, 0.003}, 0}};
  for (const Case& c : cases) {
    CAPTURE(c.tool);
    const OracleAnswer answer = lab.oracle.follow(c.tool);
    CHECK(answer.converged);
    CHECK(answer.n_active == c.n_active);
    CHECK(norm(answer.proxy_O - c.proxy) <= tol(kExact));
  }
}

TEST_CASE("sphere oracle: it rolls around an edge on a cylinder and around a vertex on a sphere",
          "[lab][trap]") {
  // a tool on an arc around the edge, 4 to 0.05 mm in front of it
  constexpr double kRadius = 5e-3;
  const double nearer = GENERATE(4e-3, 1e-3, 5e-5);
  Lab lab(haptic::make_box({0.1, 0.1, 0.1}), kRadius);
  const Vec3 edge{0.05, 0.01, 0.05};
  lab.oracle.seed(edge + Vec3{0, 0, 0.01});
  for (int degrees = 5; degrees < 90; degrees += 5) {
    const double angle = degrees * 3.14159265358979 / 180;
    const Vec3 out{std::sin(angle), 0, std::cos(angle)};
    const OracleAnswer answer = lab.oracle.follow(edge + nearer * out);
    CAPTURE(nearer, degrees, answer.sweeps);
    CHECK(answer.converged);
    CHECK(answer.n_active == 1);
    CHECK(norm(answer.proxy_O - (edge + kRadius * out)) <= tol(kExact));
  }
  const Vec3 vertex{0.05, 0.05, 0.05}, out = normalized(Vec3{1, 2, 3});
  const OracleAnswer answer = lab.oracle.follow(vertex + nearer * out);
  CHECK(answer.converged);
  CHECK(norm(answer.proxy_O - (vertex + kRadius * out)) <= tol(kExact));
}

TEST_CASE("sphere oracle: on a ball it is the foot within the facets' sagitta, outside and inside",
          "[lab]") {
  constexpr double kBall = 0.05, kRadius = 5e-3;
  const bool inside = GENERATE(false, true);
  haptic::Soup soup = haptic::make_icosphere(kBall, 4);
  double sagitta = 0;
  for (const auto& [a, b, c] : soup.triangles) {
    const auto& v = soup.vertices;
    sagitta = std::max(sagitta, kBall - norm((v[a] + v[b] + v[c]) / 3.0));
  }
  Lab lab(inside ? haptic::test::turned_inside_out(soup) : soup, kRadius);
  const double sign = inside ? -1 : 1;
  lab.oracle.seed((kBall + 2 * sign * kRadius) * haptic::sphere_direction(0));
  for (int k = 0; k < 400; ++k) {
    const Vec3 u = haptic::sphere_direction(1e-3 * k);
    const OracleAnswer answer = lab.oracle.follow((kBall + 0.8 * sign * kRadius) * u);
    CAPTURE(inside, k);
    REQUIRE(answer.converged);
    const double expected = kBall + sign * kRadius;
    REQUIRE(norm(answer.proxy_O) <= expected + tol(1e-12));
    REQUIRE(norm(answer.proxy_O) >= expected - 2 * sagitta);
    // never nearer than its radius
    REQUIRE(behind_surface(lab.facets, answer.proxy_O, kRadius, 1e-3).depth <= 1e-14);
  }
}

TEST_CASE("sphere oracle: a plate thinner than the radius holds it on its own side",
          "[lab][trap]") {
  Lab lab(haptic::make_box({0.1, 0.1, 1e-4}), 1e-3);
  lab.oracle.seed({0, 0, 2e-3});
  const OracleAnswer answer = lab.oracle.follow({0.01, 0.02, -0.04});
  CHECK(answer.converged);
  CHECK(norm(answer.proxy_O - Vec3{0.01, 0.02, 0.5e-4 + 1e-3}) <= tol(kExact));
}

TEST_CASE("sphere oracle: it spans a valley, and every answer is a local minimum",
          "[lab][property]") {
  constexpr double kRadius = 5e-3;
  haptic::EvalWork work = haptic::make_eval_work("hf:50", kRadius);
  Lab lab(std::move(work.soup), kRadius);
  lab.oracle.seed(work.path(0));
  int spanned = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 tool = work.path(1e-3 * k);
    const OracleAnswer answer = lab.oracle.follow(tool);
    CAPTURE(k);
    REQUIRE(answer.converged);
    REQUIRE(behind_surface(lab.facets, answer.proxy_O, kRadius, 1e-3).depth <= 1e-14);
    REQUIRE(free_descent(lab.facets, answer.proxy_O, tool, kRadius) <= tol(1e-12));
    spanned += answer.n_active > 1;
  }
  CHECK(spanned > 50);
}

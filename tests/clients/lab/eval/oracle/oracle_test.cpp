// SPDX-License-Identifier: GPL-3.0-or-later
// The oracles of a point and of a sphere against closed forms only: they check the renderers, so
// those cannot check them.
#include "clients/lab/eval/oracle/oracle.h"

#include <memory>

#include "clients/lab/eval/oracle/place.h"
#include "clients/lab/eval/oracle/rest_cgal.h"
#include "clients/lab/eval/scenes/workload.h"
#include "tests/support/meshes.h"
#include "tests/support/near.h"
#include "tests/support/scenes.h"

using namespace haptic;
using namespace haptic::test;

namespace {

/// An oracle with its mesh: of a point, or of a sphere.
struct Lab {
  Lab(Soup soup, double sphere)
      : made(build_shape(std::move(soup))),
        facets(made.view().mesh),
        radius(sphere),
        oracle(make_oracle(facets, radius)) {}
  void seed(const Vec3& p_O) { oracle->seed(p_O); }
  OracleAnswer follow(const Vec3& tool_O) {
    const OracleAnswer answer = oracle->follow(tool_O);
    CAPTURE(radius, tool_O, answer.sweeps);
    REQUIRE(answer.converged);
    return answer;
  }
  /// The largest error that a foot may have [m].
  double exact() const { return radius > 0 ? tol(1e-12) : 1e-14; }

  MeshShapeData made;
  FacetBins facets;
  double radius;
  std::unique_ptr<ProxyOracle> oracle;
};

double sagitta_of(const Soup& ball, double radius) {
  double sagitta = 0;
  for (const auto& [a, b, c] : ball.triangles) {
    const auto& v = ball.vertices;
    sagitta = std::max(sagitta, radius - norm((v[a] + v[b] + v[c]) / 3.0));
  }
  return sagitta;
}

}  // namespace

TEST_CASE("eval oracle: on the plane it is the foot of the tool, to the last digits", "[lab]") {
  const double radius = GENERATE(0.0, 1e-3, 5e-3);
  const Vec3 up{0, 0, radius};
  Lab lab(make_grid(0.1, 50), radius);
  lab.seed(flat_slide(0) + up);
  int touching = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 tool = flat_slide(1e-3 * k) + up;
    const OracleAnswer answer = lab.follow(tool);
    const Vec3 foot{tool.x, tool.y, std::max(tool.z, radius)};
    REQUIRE(norm(answer.proxy_O - foot) <= lab.exact());
    touching += answer.n_active;
  }
  CHECK(touching > 1500);
}

TEST_CASE("eval oracle: a corner of one, two and three planes", "[lab][trap]") {
  // walls x = 0, y = 0, z = 0 seen from the positive octant, a box inside out: a fillet of its
  // radius
  const double r = GENERATE(0.0, 2e-3);
  Soup soup = turned_inside_out(make_box({0.2, 0.2, 0.2}));
  for (Vec3& v : soup.vertices) v += {0.1, 0.1, 0.1};
  Lab lab(std::move(soup), r);
  struct Case {
    Vec3 tool, proxy;
    int n_active;
  };
  const std::vector<Case> cases{{{0.01, 0.02, -3e-3}, {0.01, 0.02, r}, 1},
                                {{-1e-3, 0.02, -3e-3}, {r, 0.02, r}, 2},
                                {{-1e-3, -2e-3, 3e-3}, {r, r, 3e-3}, 2},
                                {{-1e-3, -2e-3, -3e-3}, {r, r, r}, 3},
                                {{r - 1e-3, r - 1e-3, r - 1e-3}, {r, r, r}, 3},
                                {{0.01, r - 2e-3, 3e-3}, {0.01, r, 3e-3}, 1},
                                {{0.01, r + 1e-3, 3e-3}, {0.01, r + 1e-3, 3e-3}, 0}};
  lab.seed({0.01, 0.01, 0.01});
  for (const Case& c : cases) {
    CAPTURE(r, c.tool);
    const OracleAnswer answer = lab.follow(c.tool);
    CHECK(answer.n_active == c.n_active);
    CHECK(norm(answer.proxy_O - c.proxy) <= lab.exact());
  }
}

TEST_CASE("sphere oracle: it rolls around an edge on a cylinder and around a vertex on a sphere",
          "[lab][trap]") {
  // a tool on an arc around the edge, 4 to 0.05 mm in front of it
  constexpr double kRadius = 5e-3;
  const double nearer = GENERATE(4e-3, 1e-3, 5e-5);
  Lab lab(make_box({0.1, 0.1, 0.1}), kRadius);
  const Vec3 edge{0.05, 0.01, 0.05};
  lab.seed(edge + Vec3{0, 0, 0.01});
  for (int degrees = 5; degrees < 90; degrees += 5) {
    const double angle = degrees * 3.14159265358979 / 180;
    const Vec3 out{std::sin(angle), 0, std::cos(angle)};
    const OracleAnswer answer = lab.follow(edge + nearer * out);
    CAPTURE(nearer, degrees);
    CHECK(answer.n_active == 1);
    CHECK(norm(answer.proxy_O - (edge + kRadius * out)) <= lab.exact());
  }
  const Vec3 vertex{0.05, 0.05, 0.05}, out = normalized(Vec3{1, 2, 3});
  CHECK(norm(lab.follow(vertex + nearer * out).proxy_O - (vertex + kRadius * out)) <= lab.exact());
}

TEST_CASE("eval oracle: on a sphere it is the foot within the facets' sagitta", "[lab]") {
  constexpr double kBall = 0.05;
  const double radius = GENERATE(0.0, 5e-3), depth = radius > 0 ? 0.2 * radius : 1e-3;
  const bool inside = radius > 0 && GENERATE(false, true);
  const Soup ball = make_icosphere(kBall, radius > 0 ? 4 : 5);
  const double sagitta = sagitta_of(ball, kBall), sign = inside ? -1 : 1;
  double longest = 0;
  for (const auto& [a, b, c] : ball.triangles) {
    for (const auto& [i, j] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
      longest = std::max(longest, norm(ball.vertices[i] - ball.vertices[j]));
    }
  }
  Lab lab(inside ? turned_inside_out(ball) : ball, radius);
  const double expected = kBall + sign * radius;
  lab.seed((expected + sign * (radius + 1e-3)) * sphere_direction(0));
  for (int k = 0; k < 500; ++k) {
    const Vec3 u = sphere_direction(1e-3 * k);
    const OracleAnswer answer = lab.follow((expected - sign * depth) * u);
    CAPTURE(inside, k);
    REQUIRE(norm(answer.proxy_O) <= expected + tol(radius > 0 ? 1e-12 : 0));
    REQUIRE(norm(answer.proxy_O) >= expected - 2 * sagitta);
    REQUIRE(norm(answer.proxy_O - expected * u) <= longest);
    // never nearer than its radius
    if (radius > 0)
      REQUIRE(behind_surface(lab.facets, answer.proxy_O, radius, 1e-3).depth <= 1e-14);
  }
}

TEST_CASE("eval oracle: a thin plate holds it on its own side", "[lab][trap]") {
  const double radius = GENERATE(0.0, 1e-3);
  Lab lab(make_box({0.1, 0.1, 1e-4}), radius);
  lab.seed({0, 0, 2e-3});
  const OracleAnswer answer = lab.follow({0.01, 0.02, -0.04});
  CHECK(norm(answer.proxy_O - Vec3{0.01, 0.02, 0.5e-4 + radius}) <= lab.exact());
}

TEST_CASE("eval oracle: where it has left a saddle vertex no straight way leads nearer", "[lab]") {
  Lab lab(make_bumpy_sphere(118), 0);
  const WayJudge ways(lab.made.view().mesh);
  lab.seed(sphere_slide(0, 0));
  constexpr double kLeastGain = 1e-6;  // [m]
  constexpr int kDirections = 2000;
  int left = 0;
  const uint64_t ticks = sweep(8000);  // 20,000 with HAPTIC_TORTURE_SCALE = 2.5
  for (uint64_t k = 0; k < ticks; ++k) {
    const Vec3 tool = sphere_slide(1e-3 * static_cast<double>(k), 0);
    const OracleAnswer answer = lab.oracle->follow(tool);
    if (!answer.has_left) continue;
    ++left;
    CAPTURE(k, answer.n_active, norm(answer.proxy_O - tool));
    CHECK_FALSE(ways.free_way(answer.proxy_O, tool, kLeastGain, kDirections, k));
  }
  CHECK(left > 0);
}

TEST_CASE("sphere oracle: it spans a valley, and every answer is a local minimum",
          "[lab][property]") {
  constexpr double kRadius = 5e-3;
  EvalWork work = make_eval_work("hf:50", kRadius);
  Lab lab(std::move(work.soup), kRadius);
  lab.seed(work.path(0));
  int spanned = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 tool = work.path(1e-3 * k);
    const OracleAnswer answer = lab.follow(tool);
    CAPTURE(k);
    REQUIRE(behind_surface(lab.facets, answer.proxy_O, kRadius, 1e-3).depth <= 1e-14);
    REQUIRE(free_descent(lab.facets, answer.proxy_O, tool, kRadius) <= tol(1e-12));
    spanned += answer.n_active > 1;
  }
  CHECK(spanned > 50);
}

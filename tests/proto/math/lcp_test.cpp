// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/math/lcp.cpp, cross-checked with qp.cpp.
#include "proto/math/lcp.h"

#include <limits>
#include <numeric>

#include "proto/math/qp.h"
#include "proto/math/units.h"
#include "tests/support/contact_rows.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kAgree = 1e-8;    // relative difference of the three methods
constexpr double kGravity = 9.81;  // [m/s²]

const Mat6 kUnitCube = mass_matrix(1, 1.0 / 6 * Mat3{});

double sum(std::span<const double> x) {
  return std::accumulate(x.begin(), x.end(), 0.0);
}

std::vector<MotionRow> corners(double b) {
  std::vector<MotionRow> rows;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      rows.push_back({{{0, 0, 1}, cross(Vec3{x, y, -0.5}, {0, 0, 1})}, b});
    }
  }
  return rows;
}

/// The largest speed along a row at which two twists differ, relative to the row's speeds of a_u.
double row_difference(const MotionProblem& problem, const Twist& a, const Twist& b) {
  double worst = 0;
  for (const MotionRow& row : problem.rows) {
    const double size = norm(row.J.v) * norm(problem.a_u.v) + norm(row.J.w) * norm(problem.a_u.w);
    worst = std::max(worst, std::fabs(dot(row.J, a - b)) / size);
  }
  return worst;
}

}  // namespace

TEST_CASE("lcp: cube on one contact, in closed form", "[math]") {
  // A = 2.5, b = −1
  LcpSolver solver(4);
  const std::array<double, 1> A{2.5}, b{-1};
  for (const LcpMethod method : {LcpMethod::kPivoting, LcpMethod::kGaussSeidel}) {
    const LcpSolution out = solver.solve(method, A, b);
    CHECK(out.converged);
    CHECK(out.f[0] == Approx(0.4).epsilon(1e-14));
    CHECK(std::fabs(out.a[0]) <= 1e-15);
  }
  const MotionRow row = contact_row({0.5, -0.5, 0}, {0, 1, 0}, 0, 1);
  const ImpulseStep step =
      solver.step(LcpMethod::kPivoting, factor_metric(kUnitCube), {{0, -1, 0}, {}}, {&row, 1});
  CHECK_THAT(step.v.v, IsNear({0, -0.6, 0}, 1e-14));
  CHECK_THAT(step.v.w, IsNear({0, 0, 1.2}, 1e-14));
}

TEST_CASE("lcp: a box on four corners is carried by m g h", "[math]") {
  LcpSolver solver(8);
  const Mat6 M = 2.5 * kUnitCube;
  const LcpMethod method = GENERATE(LcpMethod::kPivoting, LcpMethod::kGaussSeidel);
  const ImpulseStep out =
      solver.step(method, factor_metric(M), {{0, 0, -kGravity * kTick}, {}}, corners(0), 2000);
  CHECK(out.converged);
  CHECK(sum(out.lambda) == Approx(2.5 * kGravity * kTick).epsilon(1e-9));
  CHECK_THAT(out.v.v, IsNear({}, 1e-12));
  CHECK_THAT(out.v.w, IsNear({}, 1e-12));
}

TEST_CASE("lcp: a falling box comes as far as the gap", "[math]") {
  LcpSolver solver(8);
  const Twist v_free{{0, 0, -1}, {}};
  const ImpulseStep out =
      solver.step(LcpMethod::kPivoting, factor_metric(kUnitCube), v_free, corners(-2e-4 / kTick));
  CHECK_THAT(out.v.v, IsNear({0, 0, -0.2}, 1e-14));
  const ImpulseStep far =
      solver.step(LcpMethod::kPivoting, factor_metric(kUnitCube), v_free, corners(-1e-2 / kTick));
  CHECK(far.v == v_free);
  CHECK(sum(far.lambda) == 0);
}

TEST_CASE("lcp: a stack of three boxes, four contacts each", "[math][trap]") {
  // heights only: contact k lies between box k−1 (0 is the ground) and box k, four times over
  constexpr size_t kBoxes = 3, kRows = 4 * kBoxes;
  const double mass = 0.7;
  std::array<std::array<double, kBoxes>, kRows> J{};
  for (size_t i = 0; i < kRows; ++i) {
    J[i][i % kBoxes] = 1;
    if (i % kBoxes > 0) J[i][i % kBoxes - 1] = -1;
  }
  std::array<double, kRows * kRows> A{};
  std::array<double, kRows> b{};
  for (size_t i = 0; i < kRows; ++i) {
    for (size_t k = 0; k < kBoxes; ++k) b[i] -= J[i][k] * kGravity * kTick;
    for (size_t j = 0; j < kRows; ++j) {
      for (size_t k = 0; k < kBoxes; ++k) A[i * kRows + j] += J[i][k] * J[j][k] / mass;
    }
  }
  LcpSolver solver(kRows);
  for (const LcpMethod method : {LcpMethod::kPivoting, LcpMethod::kGaussSeidel}) {
    const LcpSolution out = solver.solve(method, A, b, 10000);
    REQUIRE(out.converged);
    for (size_t level = 0; level < kBoxes; ++level) {
      double carried = 0;
      for (size_t i = level; i < kRows; i += kBoxes) carried += out.f[i];
      const double above = static_cast<double>(kBoxes - level);
      CHECK(carried == Approx(above * mass * kGravity * kTick).epsilon(1e-9));
    }
    for (const double a : out.a) CHECK(std::fabs(a) <= 1e-12);
  }
}

TEST_CASE("lcp: random semidefinite problems with a known answer", "[math][property]") {
  Random random(21);
  LcpSolver solver(60);
  size_t solved = 0;
  for (size_t trial = 0; trial < trials(2000); ++trial) {
    const size_t n = 1 + random.index(60), rank = 1 + random.index(n);
    std::vector<double> G(n * rank), A(n * n), b(n), a(n), f(n);
    for (double& g : G) g = random.uniform(-1, 1);
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j < n; ++j) {
        for (size_t k = 0; k < rank; ++k) A[i * n + j] += G[i * rank + k] * G[j * rank + k];
      }
      (random.index(2) == 0 ? a : f)[i] = random.uniform(0, 1);
    }
    for (size_t i = 0; i < n; ++i) {
      b[i] = a[i];
      for (size_t j = 0; j < n; ++j) b[i] -= A[i * n + j] * f[j];
    }
    const LcpSolution out = solver.solve(LcpMethod::kPivoting, A, b);
    CAPTURE(trial, n, rank, out.iterations);
    solved += out.converged;
    if (!out.converged) continue;
    for (size_t i = 0; i < n; ++i) {
      REQUIRE(out.f[i] >= 0);
      REQUIRE(std::fabs(out.a[i] - a[i]) <= tol(1e-8) * static_cast<double>(n));
    }
  }
  // singular to rounding: flagged, and rare
  CHECK(500 * (trials(2000) - solved) <= trials(2000));
}

TEST_CASE("lcp: pivoting, Gauss-Seidel and least constraint agree", "[math][property]") {
  Random random(31);
  LcpSolver solver(200);
  size_t solved = 0, relaxed = 0, apart = 0;
  // in a flat wedge the residual of either method is amplified a hundred times: one in ten thousand
  const auto compare = [&](const MotionProblem& problem, const Twist& a, const Twist& b) {
    const double difference = row_difference(problem, a, b);
    REQUIRE(difference <= tol(100 * kAgree));
    apart += difference > tol(kAgree);
  };
  const auto n = sweep(6000);
  for (size_t trial = 0; trial < n; ++trial) {
    const MotionProblem problem = random_motion_problem(random, 1, {200, false, 0});
    const MotionMetric metric = factor_metric(problem.M);
    const ConstrainedMotion qp = least_constraint(metric, problem.a_u, problem.rows);
    CAPTURE(trial, problem.rows.size());
    const ImpulseStep pivoting =
        solver.step(LcpMethod::kPivoting, metric, problem.a_u, problem.rows);
    solved += pivoting.converged;
    if (pivoting.converged) {
      compare(problem, pivoting.v, qp.a);
      for (const double f : pivoting.lambda) REQUIRE(f >= 0);
    }
    if (problem.rows.size() > 24) continue;
    const ImpulseStep seidel =
        solver.step(LcpMethod::kGaussSeidel, metric, problem.a_u, problem.rows, 5000);
    relaxed += seidel.converged;
    if (seidel.converged) compare(problem, seidel.v, qp.a);
  }
  CHECK(10000 * apart <= n);
  // failures are flagged, and rare
  CHECK(1000 * (n - solved) <= n);
  CHECK(2 * relaxed > n);
}

TEST_CASE("lcp: what has no answer is flagged", "[math][trap]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LcpSolver solver(2);
  const std::array<double, 4> opposite{1, -1, -1, 1}, zero{};
  const std::array<double, 2> b{-1, -1}, bad{nan, -1};
  for (const LcpMethod method : {LcpMethod::kPivoting, LcpMethod::kGaussSeidel}) {
    CHECK_FALSE(solver.solve(method, opposite, b).converged);
    CHECK_FALSE(solver.solve(method, zero, b).converged);
    CHECK_FALSE(solver.solve(method, opposite, bad).converged);
    CHECK_FALSE(solver.solve(method, std::array<double, 9>{}, std::array<double, 3>{}).converged);
    CHECK(solver.solve(method, {}, {}).converged);
    const std::vector<MotionRow> rows(3, contact_row({}, {0, 0, 1}, 0, 1));
    const Twist v_free{{0, 0, -1}, {}};
    CHECK_FALSE(solver.step(method, factor_metric(kUnitCube), v_free, rows).converged);
    CHECK_FALSE(solver.step(method, {}, v_free, {}).converged);
    CHECK_FALSE(solver.step(method, factor_metric(kUnitCube), {{nan, 0, 0}, {}}, {}).converged);
  }
}

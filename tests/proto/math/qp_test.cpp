// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/math/qp.cpp and motion_metric.cpp.
#include "proto/math/qp.h"

#include <limits>

#include "tests/support/contact_rows.h"
#include "tests/support/least_squares.h"
#include "tests/support/near.h"
#include "tests/support/torture_scale.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kKkt = 1e-9;  // scaled residuals

const Mat6 kCube = mass_matrix(1, 1.0 / 6 * Mat3{});

void require_optimal(const MotionProblem& problem, const ConstrainedMotion& answer) {
  const KktResidual left = kkt_residual(problem, answer);
  REQUIRE(answer.converged);
  REQUIRE(left.dual <= 0);
  REQUIRE(std::max({left.primal, left.complementarity, left.stationarity}) <= tol(kKkt));
}

/// Distance in the metric.
double distance(const Mat6& M, const Twist& a, const Twist& b) {
  const Twist d = a - b;
  return std::sqrt(std::max(0.0, dot(M * d, d)));
}

/// Oracle: all subsets of at most six rows, their Lagrange points by Eigen's QR of L⁻¹Jᵀ, the
/// nearest feasible one.
Twist by_all_subsets(const MotionProblem& problem) {
  Eigen::MatrixXd M(6, 6);
  for (int i = 0; i < 36; ++i) M(i / 6, i % 6) = problem.M.a[static_cast<size_t>(i)];
  const Eigen::MatrixXd L = lower_cholesky(M);
  const auto vector = [](const Twist& t) {
    Eigen::VectorXd x(6);
    x << t.v.x, t.v.y, t.v.z, t.w.x, t.w.y, t.w.z;
    return x;
  };
  Twist best = problem.a_u;
  double least = std::numeric_limits<double>::infinity();
  for (unsigned subset = 0; subset < 1u << problem.rows.size(); ++subset) {
    const int size = __builtin_popcount(subset);
    if (size > 6) continue;
    Eigen::MatrixXd G(size, 6);
    Eigen::VectorXd missing(size);
    int i = 0;
    for (size_t k = 0; k < problem.rows.size(); ++k) {
      if ((subset >> k & 1u) == 0) continue;
      const MotionRow& row = problem.rows[k];
      G.row(i) = solve_lower(L, vector(row.J));
      missing(i++) = row.b - dot(row.J, problem.a_u);
    }
    Eigen::VectorXd y = Eigen::VectorXd::Zero(6);
    if (size > 0) y = shortest_solution(G, missing);
    const Eigen::VectorXd d = solve_lower_transposed(L, y);
    const Twist a = problem.a_u + Twist{{d[0], d[1], d[2]}, {d[3], d[4], d[5]}};
    const bool feasible = std::all_of(problem.rows.begin(), problem.rows.end(),
                                      [&](auto& row) { return dot(row.J, a) - row.b >= -1e-10; });
    if (feasible && y.norm() < least) least = y.norm(), best = a;
  }
  return best;
}

}  // namespace

TEST_CASE("qp: free space is exactly free", "[math][trap]") {
  const MotionMetric metric = factor_metric(kCube);
  const Twist a_u{{0.1, -0.2, 0.3}, {1e-3, 7, 1.0 / 3}};
  const std::vector<MotionRow> rows{contact_row({0.5, 0, 0}, {0, 0, 1}, 5, 1)};
  const ConstrainedMotion out = least_constraint(metric, a_u, rows);
  CHECK(out.converged);
  CHECK(out.a == a_u);
  CHECK(out.constraint == Wrench{});
  CHECK(out.n_active == 0);
  CHECK(least_constraint(metric, a_u, {}).a == a_u);
}

TEST_CASE("qp: cube on one contact, in closed form", "[math]") {
  // f = 0.4, a = (0, −0.6, 0, 0, 0, 1.2)
  const std::vector<MotionRow> rows{contact_row({0.5, -0.5, 0}, {0, 1, 0}, 0, 1)};
  const ConstrainedMotion out = least_constraint(factor_metric(kCube), {{0, -1, 0}, {}}, rows);
  REQUIRE(out.n_active == 1);
  CHECK(out.multiplier[0] == Approx(0.4).epsilon(1e-14));
  CHECK_THAT(out.a.v, IsNear({0, -0.6, 0}, 1e-14));
  CHECK_THAT(out.a.w, IsNear({0, 0, 1.2}, 1e-14));
  CHECK_THAT(out.constraint.f, IsNear({0, 0.4, 0}, 1e-14));
  CHECK_THAT(out.constraint.t, IsNear({0, 0, 0.2}, 1e-14));
}

TEST_CASE("qp: cube on four corners, in closed form", "[math]") {
  std::vector<MotionRow> rows;
  for (const double x : {-0.5, 0.5}) {
    for (const double z : {-0.5, 0.5}) rows.push_back(contact_row({x, -0.5, z}, {0, 1, 0}, 0, 1));
  }
  const ConstrainedMotion out = least_constraint(factor_metric(kCube), {{0, -1, 0}, {}}, rows);
  CHECK(out.converged);
  CHECK_THAT(out.a.v, IsNear({}, 1e-14));
  CHECK_THAT(out.a.w, IsNear({}, 1e-14));
  CHECK_THAT(out.constraint.f, IsNear({0, 1, 0}, 1e-14));
  CHECK_THAT(out.constraint.t, IsNear({}, 1e-14));
}

TEST_CASE("qp: pushed at 45 degrees into a frictionless plane nothing drags", "[math][trap]") {
  std::vector<MotionRow> rows;
  for (int i = 0; i < 12; ++i) {
    rows.push_back(contact_row({std::cos(i), std::sin(i), -0.5}, {0, 0, 1}, 0, 1));
  }
  const ConstrainedMotion out = least_constraint(factor_metric(kCube), {{1, 0, -1}, {}}, rows);
  CHECK_THAT(out.a.v, IsNear({1, 0, 0}, 1e-14));
  CHECK(std::hypot(out.constraint.f.x, out.constraint.f.y) <= 1e-9 * norm(out.constraint.f));
  CHECK(out.constraint.f.z == Approx(1));
}

TEST_CASE("qp: a tight peg keeps its tangential motion", "[math][trap]") {
  // opposite normals all round: only sliding along and turning about the axis remain
  std::vector<MotionRow> rows;
  for (const double z : {-0.1, 0.1}) {
    for (int i = 0; i < 16; ++i) {
      const Vec3 out{std::cos(i * 0.3927), std::sin(i * 0.3927), 0};
      rows.push_back(contact_row(0.02 * out + Vec3{0, 0, z}, -out, 0, 1));
    }
  }
  const Twist a_u{{1e-3, -2e-3, 5e-3}, {0.03, 0.02, 0.01}};
  const ConstrainedMotion out = least_constraint(factor_metric(kCube), a_u, rows);
  CHECK(out.converged);
  CHECK_FALSE(out.contradictory);
  CHECK_THAT(out.a.v, IsNear({0, 0, 5e-3}, 1e-15));
  CHECK_THAT(out.a.w, IsNear({0, 0, 0.01}, 1e-15));
}

TEST_CASE("qp: the same contact many times is one contact", "[math][trap]") {
  for (const double differs : {0.0, 1e-16, 1e-14, 1e-12}) {
    std::vector<MotionRow> rows;
    for (int i = 0; i < 64; ++i) {
      rows.push_back(contact_row({0.5, -0.5, differs * i}, {0, 1, 0}, -differs * i, 1));
    }
    const ConstrainedMotion out = least_constraint(factor_metric(kCube), {{0, -1, 0}, {}}, rows);
    CAPTURE(differs);
    CHECK(out.converged);
    CHECK_THAT(out.a.v, IsNear({0, -0.6, 0}, 1e-9));
    CHECK_THAT(out.a.w, IsNear({0, 0, 1.2}, 1e-9));
  }
}

TEST_CASE("qp: forty rows through one point", "[math][trap]") {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    MotionProblem problem{random_metric(random, 1), {}, {}};
    const Twist corner{random.direction(), random.direction()};
    for (int i = 0; i < 40; ++i) {
      Twist J{random.direction(), random.direction()};
      // all bound the side away from the goal, so that the corner is the solution
      if (dot(J, corner) < 0) J = -1 * J;
      problem.rows.push_back({J, dot(J, corner)});
    }
    require_optimal(problem, least_constraint(factor_metric(problem.M), problem.a_u, problem.rows));
  }
}

TEST_CASE("qp: rows that contradict one another do not freeze the motion", "[math][trap]") {
  // a slot too narrow by 2 µm, and a push across it and along it
  const std::vector<MotionRow> rows{contact_row({0, 1e-2, 0}, {0, -1, 0}, -1e-6, 1e-4),
                                    contact_row({0, -1e-2, 0}, {0, 1, 0}, -1e-6, 1e-4)};
  const ConstrainedMotion out = least_constraint(factor_metric(kCube), {{1e-3, 1e-3, 0}, {}}, rows);
  CHECK(out.contradictory);
  CHECK(out.converged);
  CHECK_THAT(out.a.v, IsNear({1e-3, 0, 0}, 1e-15));
}

TEST_CASE("qp: a flat wedge that overlaps does not shoot the body out", "[math][trap]") {
  // two walls 2e-4 rad from opposite: leaving both overlaps takes 10⁴ times their depth
  const double tilt = GENERATE(1e-4, 1e-7, 1e-9, 1e-11);
  const Vec3 left = normalized(Vec3{tilt, 1, 0}), right = normalized(Vec3{tilt, -1, 0});
  const std::vector<MotionRow> rows{contact_row({}, left, -1e-5, 1e-4),
                                    contact_row({}, right, -1e-5, 1e-4)};
  const ConstrainedMotion out = least_constraint(factor_metric(kCube), {}, rows);
  CHECK(out.contradictory);
  CHECK(out.converged);
  CHECK(out.a == Twist{});
}

TEST_CASE("qp: an overlap pushes out, by no more than is allowed", "[math]") {
  const MotionMetric metric = factor_metric(kCube);
  const auto lifted = [&](double gap) {
    const MotionRow row = contact_row({}, {0, 0, 1}, gap, 1e-4);
    return least_constraint(metric, {}, {&row, 1}).a.v.z;
  };
  CHECK(lifted(-1e-5) == Approx(1e-5));
  CHECK(lifted(-1) == Approx(1e-4));
  CHECK(lifted(1) == 0);
}

TEST_CASE("qp: what is not finite or no metric is flagged", "[math][trap]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const MotionMetric cube = factor_metric(kCube);
  for (const double bad : {nan, infinite, -infinite}) {
    std::vector<MotionRow> rows(3, contact_row({}, {0, 0, 1}, 0, 1));
    rows[1].b = bad;
    const ConstrainedMotion bound = least_constraint(cube, {{0, 0, -1}, {}}, rows);
    CHECK_FALSE(bound.converged);
    CHECK(bound.a == Twist{});
    rows[1] = contact_row({0, bad, 0}, {0, 0, 1}, 0, 1);
    CHECK_FALSE(least_constraint(cube, {{0, 0, -1}, {}}, rows).converged);
    rows.resize(1);
    CHECK_FALSE(least_constraint(cube, {{0, 0, -1}, {0, bad, 0}}, rows).converged);
    Mat6 M = kCube;
    M(3, 1) = bad;
    CHECK_FALSE(factor_metric(M).valid);
  }
  Mat6 flat = kCube;
  flat(5, 5) = 0;
  CHECK_FALSE(least_constraint(factor_metric(flat), {}, {}).converged);
  flat(5, 5) = -1;
  CHECK_FALSE(factor_metric(flat).valid);
  const MotionRow row = contact_row({}, {0, 0, 1}, 0, 1);
  const std::array<int, 3> nonsense{-1, 1, 1000};
  CHECK(least_constraint(cube, {{0, 0, -1}, {}}, {&row, 1}, nonsense).converged);
}

TEST_CASE("qp: the metric's factors undo it", "[math][property]") {
  Random random(2);
  for (int trial = 0; trial < 300; ++trial) {
    const double radius = trial % 2 == 0 ? 1 : 0.05;
    const Mat6 M = random_metric(random, radius);
    const MotionMetric metric = factor_metric(M);
    REQUIRE(metric.valid);
    const Twist a{random.direction(), 1 / radius * random.direction()};
    const Twist back = response(metric, M * a);
    REQUIRE(distance(M, a, back) <= tol(1e-13) * std::sqrt(dot(M * a, a)));
    const Vec6 y = coordinates(metric, a);
    REQUIRE(dot(y, y) == Approx(dot(M * a, a)).epsilon(1e-13));
  }
}

TEST_CASE("qp: random rows agree with all subsets", "[math][property]") {
  Random random(7);
  for (size_t trial = 0; trial < trials(600); ++trial) {
    MotionProblem problem = random_motion_problem(random, 1, {9, false, 0});
    const double size = norm(problem.a_u.v);
    problem.a_u = 1 / size * problem.a_u;
    for (MotionRow& row : problem.rows) row.b /= size;
    const ConstrainedMotion out =
        least_constraint(factor_metric(problem.M), problem.a_u, problem.rows);
    CAPTURE(trial, problem.rows.size());
    REQUIRE(distance(problem.M, out.a, by_all_subsets(problem)) <= tol(1e-8));
  }
}

TEST_CASE("qp: nothing is left over on 100,000 random problems", "[math][property]") {
  const double radius = GENERATE(1.0, 0.05);
  Random random(20261122);
  int most_iterations = 0;
  const size_t n = sweep(radius == 1 ? 90000 : 10000);
  for (size_t trial = 0; trial < n; ++trial) {
    const MotionProblem problem = random_motion_problem(random, radius);
    const ConstrainedMotion out =
        least_constraint(factor_metric(problem.M), problem.a_u, problem.rows);
    CAPTURE(trial, radius, problem.rows.size());
    require_optimal(problem, out);
    most_iterations = std::max(most_iterations, out.iterations);
  }
  CHECK(most_iterations < 90);
}

TEST_CASE("qp: nothing is left over where overlaps push a tool at rest", "[math][property]") {
  Random random(13);
  for (size_t trial = 0; trial < sweep(10000); ++trial) {
    MotionProblem problem = random_motion_problem(random, 1, {200, true, 0.5});
    problem.a_u = (trial % 2 == 0 ? 0 : 1e-6) * problem.a_u;
    CAPTURE(trial, problem.rows.size());
    require_optimal(problem, least_constraint(factor_metric(problem.M), problem.a_u, problem.rows));
  }
}

TEST_CASE("qp: without overlaps nothing is contradictory", "[math][property]") {
  Random random(3);
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    const MotionProblem problem = random_motion_problem(random, 1, {200, true, 0});
    CAPTURE(trial);
    REQUIRE_FALSE(
        least_constraint(factor_metric(problem.M), problem.a_u, problem.rows).contradictory);
  }
}

TEST_CASE("qp: a warm start gives the cold answer in fewer steps", "[math][property]") {
  Random random(11);
  long cold_steps = 0, warm_steps = 0;
  for (size_t trial = 0; trial < trials(20000); ++trial) {
    const MotionProblem problem = random_motion_problem(random, 1, {64, false, 0});
    const MotionMetric metric = factor_metric(problem.M);
    const ConstrainedMotion before = least_constraint(metric, problem.a_u, problem.rows);
    // the hand has moved a little
    const double size = 0.02 * norm(problem.a_u.v);
    const Twist a_u = problem.a_u + Twist{size * random.direction(), size * random.direction()};
    const ConstrainedMotion cold = least_constraint(metric, a_u, problem.rows);
    const ConstrainedMotion warm = least_constraint(
        metric, a_u, problem.rows, {before.active.data(), static_cast<size_t>(before.n_active)});
    CAPTURE(trial, problem.rows.size());
    const double norm_u = std::sqrt(dot(problem.M * a_u, a_u));
    REQUIRE(distance(problem.M, warm.a, cold.a) <= tol(1e-9) * norm_u);
    REQUIRE(warm.converged == cold.converged);
    cold_steps += cold.iterations;
    warm_steps += warm.iterations;
  }
  CHECK(warm_steps < cold_steps);
}

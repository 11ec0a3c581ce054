// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/peers/qp.h"

#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>

#include <memory>
#ifdef HAPTICD_BULLET
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#endif

namespace haptic {

Twist cgal_least_constraint(const Mat6& M, const Twist& a_u, std::span<const MotionRow> rows) {
  // the unknowns are unbounded; CGAL minimises xᵀDx + cᵀx and takes 2D = M
  CGAL::Quadratic_program<double> program(CGAL::LARGER, false, 0, false, 0);
  const Wrench pull = M * a_u;
  const Vec6 c = components(pull.f, pull.t);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      program.set_d(i, j, M(static_cast<size_t>(i), static_cast<size_t>(j)));
    }
    program.set_c(i, -c[static_cast<size_t>(i)]);
  }
  for (size_t k = 0; k < rows.size(); ++k) {
    const Vec6 J = components(rows[k].J.v, rows[k].J.w);
    for (size_t i = 0; i < 6; ++i) program.set_a(static_cast<int>(i), static_cast<int>(k), J[i]);
    program.set_b(static_cast<int>(k), rows[k].b);
  }
  const auto solution = CGAL::solve_quadratic_program(program, CGAL::Gmpzf());
  Vec6 a{};
  auto value = solution.variable_values_begin();
  for (double& x : a) x = CGAL::to_double(*value++);
  return {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}};
}

namespace {

#ifdef HAPTICD_BULLET
class BulletDantzig {
 public:
  bool operator()(std::span<const double> A, std::span<const double> b, std::vector<double>& f) {
    const auto n = static_cast<int>(b.size());
    A_.resize(n, n);
    b_.resize(n), f_.resize(n), low_.resize(n), high_.resize(n), dependency_.resize(n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        A_.setElem(i, j, static_cast<btScalar>(A[static_cast<size_t>(i * n + j)]));
      }
      // A f = b + w
      b_[i] = static_cast<btScalar>(-b[static_cast<size_t>(i)]);
      low_[i] = 0, high_[i] = SIMD_INFINITY;
      dependency_[i] = -1;
    }
    f_.setZero();
    const bool solved = solver_.solveMLCP(A_, b_, f_, low_, high_, dependency_, n);
    f.resize(b.size());
    for (int i = 0; i < n; ++i) f[static_cast<size_t>(i)] = static_cast<double>(f_[i]);
    return solved;
  }

 private:
  btDantzigSolver solver_;
  btMatrixXu A_;
  btVectorXu b_, f_, low_, high_;
  btAlignedObjectArray<int> dependency_;
};
#endif

}  // namespace

DantzigPeer make_bullet_dantzig() {
#ifdef HAPTICD_BULLET
  return [solver = std::make_shared<BulletDantzig>()](auto A, auto b, auto& f) {
    return (*solver)(A, b, f);
  };
#else
  return {};
#endif
}

}  // namespace haptic

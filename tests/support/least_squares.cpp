// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/least_squares.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace haptic::test {

Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& G, const Eigen::VectorXd& b) {
  return G.completeOrthogonalDecomposition().solve(b);
}

Eigen::MatrixXd lower_cholesky(const Eigen::MatrixXd& M) {
  return M.llt().matrixL();
}

Eigen::VectorXd solve_lower(const Eigen::MatrixXd& L, const Eigen::VectorXd& b) {
  return L.triangularView<Eigen::Lower>().solve(b);
}

Eigen::VectorXd solve_lower_transposed(const Eigen::MatrixXd& L, const Eigen::VectorXd& b) {
  return L.transpose().triangularView<Eigen::Upper>().solve(b);
}

}  // namespace haptic::test

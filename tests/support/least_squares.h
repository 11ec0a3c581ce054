// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Eigen's decompositions for test oracles, in one file because they take long to compile.
namespace haptic::test {

/// The shortest x that minimises |G x − b|, by complete orthogonal decomposition.
Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& G, const Eigen::VectorXd& b);

/// L of M = L Lᵀ, M symmetric and positive definite.
Eigen::MatrixXd lower_cholesky(const Eigen::MatrixXd& M);

/// L⁻¹ b of a lower triangular L.
Eigen::VectorXd solve_lower(const Eigen::MatrixXd& L, const Eigen::VectorXd& b);

/// L⁻ᵀ b of a lower triangular L.
Eigen::VectorXd solve_lower_transposed(const Eigen::MatrixXd& L, const Eigen::VectorXd& b);

}  // namespace haptic::test

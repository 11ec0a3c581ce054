// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Eigen's decompositions, for oracles. They take long to compile, so they are called from one
/// file.
namespace haptic::test {

/// The shortest x with the least |G x − b|, by complete orthogonal decomposition.
Eigen::VectorXd shortest_solution(const Eigen::MatrixXd& G, const Eigen::VectorXd& b);

/// L of M = L Lᵀ, M symmetric and positive definite.
Eigen::MatrixXd lower_cholesky(const Eigen::MatrixXd& M);

/// L⁻¹ b of a lower triangular L.
Eigen::VectorXd solve_lower(const Eigen::MatrixXd& L, const Eigen::VectorXd& b);

/// L⁻ᵀ b of a lower triangular L.
Eigen::VectorXd solve_lower_transposed(const Eigen::MatrixXd& L, const Eigen::VectorXd& b);

}  // namespace haptic::test

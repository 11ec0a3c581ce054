// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/given/statement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>

#include "sim/given/local_model.h"

namespace haptic {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr double kRank = 1e-9;  // of the largest: what is less does not answer

Matrix6 matrix_of(const std::array<double, 36>& numbers) {
  return Eigen::Map<const Matrix6>(numbers.data());
}

bool has_finite_numbers(const GivenMotion& said) {
  return haptic::is_finite(said.X_WO) && is_unit(said.X_WO.q) && haptic::is_finite(said.V_WO) &&
         haptic::is_finite(said.acceleration_W) && all_finite(said.mobility) &&
         all_finite(said.stiffness) && all_finite(said.damping);
}

/// By which rows and columns of moving and of turning are scaled to ones on the diagonal at most,
/// because a mobility is a million times larger turning than moving.
Eigen::Matrix<double, 6, 1> scale_of(const Matrix6& m) {
  const auto scale = [](double most) { return most > 0 ? 1 / std::sqrt(most) : 0; };
  Eigen::Matrix<double, 6, 1> out;
  out.head<3>().setConstant(scale(m.diagonal().head<3>().maxCoeff()));
  out.tail<3>().setConstant(scale(m.diagonal().tail<3>().maxCoeff()));
  return out;
}

/// Symmetric, and no direction below zero but for rounding, as of J M⁻¹ Jᵀ along a rail.
bool is_semidefinite(const Matrix6& m, double tolerance) {
  const Eigen::Matrix<double, 6, 1> scale = scale_of(m);
  const Matrix6 scaled = scale.asDiagonal() * m * scale.asDiagonal();
  // where nothing answers there is no part of what does
  for (Eigen::Index i = 0; i < 6; ++i) {
    if (scale(i) == 0 && !(m.row(i).isZero(0) && m.col(i).isZero(0))) return false;
  }
  if (!((scaled - scaled.transpose()).cwiseAbs().maxCoeff() <= tolerance)) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(0.5 * (scaled + scaled.transpose()),
                                                     Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()(0) >= -tolerance;
}

/// True if the matrix answers in some direction, and by less than that.
bool has_less_than(const Eigen::Matrix3d& m, double least) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(0.5 * (m + m.transpose()),
                                                             Eigen::EigenvaluesOnly);
  const Eigen::Vector3d& values = eigen.eigenvalues();
  return std::ranges::any_of(values, [&](double e) { return e > kRank * values(2) && e < least; });
}

}  // namespace

GiverRefusal refusal_of(const GivenMotion& said, const StatementLimits& limits) {
  if (!has_finite_numbers(said)) return GiverRefusal::kNotFinite;
  const bool is_near = norm(said.X_WO.p) <= limits.distance && norm(said.V_WO.v) <= limits.speed &&
                       norm(said.V_WO.w) <= limits.turning &&
                       norm(said.acceleration_W.v) <= limits.acceleration &&
                       norm(said.acceleration_W.w) <= limits.acceleration;
  if (!is_near) return GiverRefusal::kTooFast;
  const Matrix6 M = matrix_of(said.mobility), K = matrix_of(said.stiffness),
                D = matrix_of(said.damping);
  for (const Matrix6* m : {&M, &K, &D}) {
    if (!is_semidefinite(*m, limits.symmetry)) return GiverRefusal::kNotSymmetric;
  }
  const auto is_within = [](const Matrix6& m, double most) {
    return m.cwiseAbs().maxCoeff() <= most;
  };
  if (!is_within(K, limits.stiffness) || !is_within(D, limits.damping)) {
    return GiverRefusal::kTooStiff;
  }
  if (has_less_than(M.topLeftCorner<3, 3>(), limits.least_mobility) ||
      has_less_than(M.bottomRightCorner<3, 3>(), limits.least_mobility)) {
    return GiverRefusal::kTooLight;
  }
  const bool is_heavy = M.topLeftCorner<3, 3>().trace() <= 3 * limits.mobility &&
                        M.bottomRightCorner<3, 3>().trace() <= 3 * limits.turning_mobility;
  if (!is_heavy) return GiverRefusal::kTooLight;
  const bool is_slow =
      (M * K).trace() <= kFastestModel * kFastestModel && (M * D).trace() <= kFastestModel;
  return is_slow ? GiverRefusal::kNone : GiverRefusal::kTooStiff;
}

Mat6 mass_of_mobility(const std::array<double, 36>& mobility) {
  const Matrix6 m = matrix_of(mobility);
  const Eigen::Matrix<double, 6, 1> scale = scale_of(m);
  const Matrix6 scaled = scale.asDiagonal() * (0.5 * (m + m.transpose())) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  const Eigen::Matrix<double, 6, 1> inverse =
      eigen.eigenvalues().unaryExpr([](double e) { return e > kRank ? 1 / e : 0; });
  const Matrix6 mass = scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
                       eigen.eigenvectors().transpose() * scale.asDiagonal();
  Mat6 out;
  Eigen::Map<Matrix6>(out.a.data()) = mass;
  return out;
}

}  // namespace haptic

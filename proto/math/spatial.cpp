// SPDX-License-Identifier: Apache-2.0
#include "proto/math/spatial.h"

#include <Eigen/LU>

namespace haptic {
namespace {

constexpr double kSingular = 1e-14;  // smallest pivot relative to the largest

}  // namespace

bool solve(const Mat6& A, const Wrench& b, Twist& x) {
  using Matrix = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  x = {};
  const std::array<double, 6> right = components(b.f, b.t);
  // rows of force and torque may differ by orders of magnitude: scales each to one
  Matrix scaled = Eigen::Map<const Matrix>(A.a.data());
  Eigen::Matrix<double, 6, 1> scaled_right =
      Eigen::Map<const Eigen::Matrix<double, 6, 1>>(right.data());
  for (int i = 0; i < 6; ++i) {
    const double largest = scaled.row(i).cwiseAbs().maxCoeff();
    if (!(largest > 0) || !std::isfinite(largest)) return false;
    scaled.row(i) /= largest;
    scaled_right[i] /= largest;
  }
  const Eigen::PartialPivLU<Matrix> lu(scaled);
  const auto pivots = lu.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > kSingular * pivots.maxCoeff())) return false;
  const Eigen::Matrix<double, 6, 1> y = lu.solve(scaled_right);
  if (!y.allFinite()) return false;
  x = {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
  return true;
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/mobility.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kFixed = 1e-5;  // of the free mobility: what is less is held

constexpr int kMostRows = static_cast<int>(6 * kMostNeighbours);  // each neighbour is a body
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostRows, kMostRows>;

/// The bodies looked at, the pushed one first.
struct Neighbours {
  std::array<uint32_t, kMostNeighbours> objects{};
  size_t n = 0;

  /// Place of an object in the list; n: it is not there.
  size_t find(uint32_t object) const {
    return static_cast<size_t>(std::find(objects.begin(), objects.begin() + n, object) -
                               objects.begin());
  }
};

Neighbours neighbours_of(std::span<const ConstraintRow> rows, uint32_t object, size_t most) {
  Neighbours found;
  found.objects[found.n++] = object;
  for (size_t next = 0; next < found.n && found.n < most; ++next) {
    for (const ConstraintRow& row : rows) {
      for (const auto& [from, to] : {std::pair{row.a, row.b}, std::pair{row.b, row.a}}) {
        if (from != found.objects[next] || to == kNoMass || found.n == most) continue;
        if (found.find(to) == found.n) found.objects[found.n++] = to;
      }
    }
  }
  return found;
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 vector_of(const Twist& row) {
  return {row.v.x, row.v.y, row.v.z, row.w.x, row.w.y, row.w.z};
}

/// Mass and inertia of the bodies, block by block.
Matrix inertia_of(const Neighbours& near, std::span<const BodyInertia> bodies) {
  const auto size = static_cast<Eigen::Index>(6 * near.n);
  Matrix inertia = Matrix::Zero(size, size);
  for (size_t k = 0; k < near.n; ++k) {
    const BodyInertia& body = bodies[near.objects[k]];
    const auto at = static_cast<Eigen::Index>(6 * k);
    for (int i = 0; i < 3; ++i) {
      inertia(at + i, at + i) = body.mass;
      for (int j = 0; j < 3; ++j) inertia(at + 3 + i, at + 3 + j) = body.inertia_W.row[i][j];
    }
  }
  return inertia;
}

/// Adds κ AᵀA to the lower triangle; true if any row holds any of the bodies.
bool add_rows(Matrix& inertia, const Neighbours& near, std::span<const ConstraintRow> rows,
              double kappa) {
  bool any = false;
  for (const ConstraintRow& row : rows) {
    const size_t a = row.a == kNoMass ? near.n : near.find(row.a);
    const size_t b = row.b == kNoMass ? near.n : near.find(row.b);
    if (a == near.n && b == near.n) continue;
    any = true;
    const Vector6 of_a = vector_of(row.row_a), of_b = vector_of(row.row_b);
    const auto at_a = static_cast<Eigen::Index>(6 * a), at_b = static_cast<Eigen::Index>(6 * b);
    if (a < near.n) inertia.block<6, 6>(at_a, at_a) += kappa * of_a * of_a.transpose();
    if (b < near.n) inertia.block<6, 6>(at_b, at_b) += kappa * of_b * of_b.transpose();
    if (a == near.n || b == near.n) continue;
    if (a > b) inertia.block<6, 6>(at_a, at_b) += kappa * of_a * of_b.transpose();
    if (b > a) inertia.block<6, 6>(at_b, at_a) += kappa * of_b * of_a.transpose();
  }
  return any;
}

}  // namespace

Mat6 mobility_at_centre(std::span<const BodyInertia> bodies, std::span<const ConstraintRow> rows,
                        uint32_t object, size_t n_bodies) {
  HAPTIC_ASSERT(object < bodies.size() && bodies[object].mass > 0);
  HAPTIC_ASSERT(n_bodies >= 1 && n_bodies <= kMostNeighbours);
  const Neighbours near = neighbours_of(rows, object, n_bodies);
  double heaviest = 0;
  for (size_t k = 0; k < near.n; ++k) heaviest = std::max(heaviest, bodies[near.objects[k]].mass);
  Matrix inertia = inertia_of(near, bodies);
  const bool any = add_rows(inertia, near, rows, kHold * heaviest);
  Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMostRows, 6> units =
      Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMostRows, 6>::Zero(inertia.rows(), 6);
  units.topRows<6>().setIdentity();
  const Eigen::LLT<Matrix> factor(inertia.selfadjointView<Eigen::Lower>());
  units = factor.solve(units);
  Mat6 mobility;
  double moving = 0;
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = 0; j < 6; ++j) {
      mobility(static_cast<size_t>(i), static_cast<size_t>(j)) = 0.5 * (units(i, j) + units(j, i));
    }
    // of a wrench's share of its own motion without rows: 1 where it is free, 0 where it is held
    const double free = i < 3 ? 1 / bodies[object].mass
                              : 1 / bodies[object].inertia_W.row[i - 3][static_cast<int>(i - 3)];
    moving = std::max(moving, units(i, i) / free);
  }
  return any && moving < kFixed ? Mat6{} : mobility;
}

Mat6 mobility_at(const Mat6& at_centre, const Vec3& arm_W) {
  // v_origin = v_centre + ω × arm: T = [1, −[arm]×; 0, 1]
  Mat6 T;
  for (size_t i = 0; i < 6; ++i) T(i, i) = 1;
  add_block(T, 0, 3, -1 * skew(arm_W));
  return T * at_centre * transpose(T);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/weight_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr double kArm = 0.1;         // to the kilogram of a column [m]
constexpr size_t kColumns = 3;       // of a link
constexpr double kTold = 0.02;       // of the largest: a smaller part of the columns is noise
constexpr double kFarthest = 0.5;    // centre of a link, from its joint [m]
constexpr double kLeastMass = 1e-5;  // [kg]

/// The masses of these unknowns; false: a centre would lie too far away.
bool table_of(const Eigen::VectorXd& x, size_t n_links, GravityConfig& gravity) {
  gravity.handle.mass = x[0];
  for (size_t i = 0; i < n_links; ++i) {
    const auto at = static_cast<Eigen::Index>(1 + kColumns * i);
    const double mass = x[at], y = x[at + 1], z = x[at + 2];
    LinkMass& link = gravity.links[i];
    link = {};
    if (std::hypot(mass, y, z) < kLeastMass) continue;
    link = {mass, {kArm, kArm * y / mass, kArm * z / mass}};
    if (!(norm(link.centre) < kFarthest)) return false;
  }
  return true;
}

Eigen::VectorXd solved(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> columns;
  columns.setThreshold(kTold);
  return columns.compute(A).solve(b);
}

void judge(const Eigen::VectorXd& missing, const std::vector<WeighedPlace>& places,
           WeightFit& fit) {
  double sum = 0;
  fit.least_weight = norm(places[0].weight_B);
  for (size_t i = 0; i < places.size(); ++i) {
    const double off = missing.segment<3>(static_cast<Eigen::Index>(3 * i)).norm();
    const double weight = norm(places[i].weight_B);
    sum += off * off;
    fit.largest_residual = std::max(fit.largest_residual, off);
    fit.least_weight = std::min(fit.least_weight, weight);
    fit.most_weight = std::max(fit.most_weight, weight);
    fit.friction += places[i].friction / static_cast<double>(places.size());
    fit.most_friction = std::max(fit.most_friction, places[i].friction);
  }
  fit.residual = std::sqrt(sum / static_cast<double>(places.size()));
}

}  // namespace

std::vector<Vec3> holding_columns(const HoldingOf& holding, const Vec3& down_B, size_t n_links) {
  GravityConfig unit;
  unit.down_B = down_B;
  unit.handle.mass = 1;
  std::vector<Vec3> columns{holding(unit).f};
  unit.handle.mass = 0;
  for (size_t i = 0; i < n_links; ++i) {
    const auto at = [&](const Vec3& centre) {
      unit.links[i] = {1, centre};
      return holding(unit).f;
    };
    const Vec3 origin = at({});
    columns.push_back(at({kArm, 0, 0}));
    columns.push_back(at({0, kArm, 0}) - origin);
    columns.push_back(at({0, 0, kArm}) - origin);
    unit.links[i] = {};
  }
  return columns;
}

WeightFit fit_weight(const std::vector<WeighedPlace>& places, const Vec3& down_B, size_t n_links) {
  HAPTIC_ASSERT(!places.empty() && n_links <= kMostLinks);
  const auto rows = static_cast<Eigen::Index>(3 * places.size());
  const auto unknowns = static_cast<Eigen::Index>(1 + kColumns * n_links);
  Eigen::MatrixXd A(rows, unknowns);
  Eigen::VectorXd b(rows);
  for (size_t i = 0; i < places.size(); ++i) {
    HAPTIC_ASSERT(places[i].columns.size() == static_cast<size_t>(unknowns));
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<Eigen::Index>(3 * i) + k;
      b[row] = places[i].weight_B[k];
      for (Eigen::Index c = 0; c < unknowns; ++c) {
        A(row, c) = places[i].columns[static_cast<size_t>(c)][k];
      }
    }
  }
  WeightFit fit;
  fit.gravity.down_B = down_B;
  Eigen::VectorXd x = solved(A, b);
  if (!table_of(x, n_links, fit.gravity)) {
    for (size_t i = 0; i < n_links; ++i) {
      A.middleCols(static_cast<Eigen::Index>(kColumns * i) + 2, 2).setZero();
    }
    x = solved(A, b);
    table_of(x, n_links, fit.gravity);
  }
  judge(b - A * x, places, fit);
  return fit;
}

std::string gravity_block(const GravityConfig& gravity, std::span<const std::string_view> names) {
  const Vec3& down = gravity.down_B;
  std::string text;
  if (down != Vec3{}) {
    text = formatted("[device.gravity]\ndown = [%.6g, %.6g, %.6g]\n", down.x, down.y, down.z);
  }
  for (size_t i = 0; i < names.size() && !names[i].empty(); ++i) {
    const LinkMass& link = i == 0 ? gravity.handle : gravity.links[i - 1];
    const Vec3 mm = 1e3 * link.centre;
    text += "[device.gravity." + std::string(names[i]) + "]\n" +
            formatted("mass = \"%.2f g\"\n", 1e3 * link.mass);
    if (mm == Vec3{}) continue;
    text += formatted("centre = [\"%.2f mm\", \"%.2f mm\", \"%.2f mm\"]\n", mm.x, mm.y, mm.z);
  }
  return replaced(text, {{"-0.00 ", "0.00 "}});
}

}  // namespace haptic

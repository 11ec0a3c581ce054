// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <vector>

#include "proto/math/qp.h"
#include "tests/support/meshes.h"

namespace haptic::test {

/// A motion to be constrained.
struct MotionProblem {
  Mat6 M;
  Twist a_u;
  std::vector<MotionRow> rows;
};

/// The metric of a body of this size: every third one diagonal, else any positive definite one.
inline Mat6 random_metric(Random& random, double radius) {
  if (random.index(3) == 0) {
    const double mass = random.uniform(0.05, 2), inertia = mass * radius * radius;
    Mat3 I;
    for (int i = 0; i < 3; ++i) I.row[i][i] = inertia * random.uniform(0.1, 0.6);
    return mass_matrix(mass, I);
  }
  Mat6 M = mass_matrix(0.1, 0.05 * radius * radius * Mat3{});
  for (int k = 0; k < 8; ++k) {
    const Twist t{random.direction(), radius * random.uniform(0, 1) * random.direction()};
    add_outer(M, {t.v, t.w}, t);
  }
  return M;
}

struct RowsOptions {
  size_t most = 200;           // rows; most problems have no more than 24
  bool nearly_equal = true;    // also rows within 1e-15 to 0.1 of others or of their opposites
  double largest_push = 2e-3;  // b > 0, of the size of the motion; 0: no overlaps
};

/// Contacts all around, on a plane, around a peg, through one point, in a bundle; some duplicate or
/// oppose others. Rows have unit normals and lever arms up to `radius`.
inline MotionProblem random_motion_problem(Random& random, double radius,
                                           const RowsOptions& options = {}) {
  MotionProblem problem;
  problem.M = random_metric(random, radius);
  const double size = radius * std::pow(10, random.uniform(-5, 0));
  problem.a_u = {size * random.direction(),
                 size / radius * random.uniform(0, 1) * random.direction()};
  const size_t n =
      1 + random.index(random.index(4) == 0 ? options.most : std::min<size_t>(24, options.most));
  const size_t arrangement = random.index(5), gaps = random.index(4);
  const Vec3 axis = random.direction();
  struct Place {
    Vec3 normal, r;
  };
  std::vector<Place> places;
  while (places.size() < n) {
    Place place{random.direction(), radius * random.uniform(0, 1) * random.direction()};
    if (arrangement == 1) place.normal = axis;
    if (arrangement == 2) place.normal = normalized(cross(axis, place.normal));
    if (arrangement == 3) place.r = {};
    if (arrangement == 4) place.normal = normalized(axis + 0.3 * place.normal);
    const size_t relative = random.index(options.nearly_equal ? 10 : 20);
    if (!places.empty() && relative < 4) {
      const Place& other = places[random.index(places.size())];
      const double sign = relative % 2 == 0 ? 1 : -1;
      // exact, or nearly
      const double differs = relative < 2 ? 0 : std::pow(10, random.uniform(-15, -1));
      if (relative < 2 || options.nearly_equal) {
        place = {sign * normalized(other.normal + differs * random.direction()),
                 other.r + radius * differs * random.direction()};
        if (relative < 2) place = {sign * other.normal, other.r};
      }
    }
    places.push_back(place);
  }
  for (const Place& place : places) {
    double gap = 0;
    if (gaps == 1 || (gaps == 2 && random.index(2) == 0)) gap = size * random.uniform(0, 1);
    if (gaps == 3) gap = -size * random.uniform(-0.5, options.largest_push);
    problem.rows.push_back(contact_row(place.r, place.normal, gap, size));
  }
  return problem;
}

/// Residual of the KKT conditions, relative to each row's sum of speeds and to the wrenches.
struct KktResidual {
  double primal = 0, dual = 0, complementarity = 0, stationarity = 0;
};

inline KktResidual kkt_residual(const MotionProblem& problem, const ConstrainedMotion& answer) {
  KktResidual out;
  const double v = std::max(norm(answer.a.v), norm(problem.a_u.v));
  const double w = std::max(norm(answer.a.w), norm(problem.a_u.w));
  const auto slack = [&](size_t k) {
    const MotionRow& row = problem.rows[k];
    const double b = answer.contradictory ? std::min(row.b, 0.0) : row.b;
    const double size = norm(row.J.v) * v + norm(row.J.w) * w + std::fabs(b);
    return size > 0 ? (dot(row.J, answer.a) - b) / size : 0;
  };
  for (size_t k = 0; k < problem.rows.size(); ++k) out.primal = std::max(out.primal, -slack(k));
  Wrench sum = problem.M * (problem.a_u - answer.a);
  const Wrench pull = problem.M * problem.a_u;
  double force = norm(pull.f), torque = norm(pull.t);
  for (size_t j = 0; j < static_cast<size_t>(answer.n_active); ++j) {
    const auto k = static_cast<size_t>(answer.active[j]);
    const Twist& J = problem.rows[k].J;
    const double multiplier = answer.multiplier[j];
    out.dual = std::max(out.dual, -multiplier);
    out.complementarity = std::max(out.complementarity, std::fabs(slack(k)));
    sum = sum + multiplier * Wrench{J.v, J.w};
    force += multiplier * norm(J.v);
    torque += multiplier * norm(J.w);
  }
  // a row with lever arm zero has no torque of its own, only the rounding of the others
  const double size = std::max({force, torque, 1e-300});
  out.stationarity = std::max(norm(sum.f), norm(sum.t)) / size;
  return out;
}

}  // namespace haptic::test

// SPDX-License-Identifier: Apache-2.0
#include "proto/math/qp.h"

#include <algorithm>
#include <limits>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMaxIterations = 100;      // rows added or dropped
constexpr double kFeasible = 1e-13;      // violation, relative to the terms it is the difference of
constexpr double kDependentRow = 1e-10;  // independent part of a row, relative to the row
constexpr double kCancelled = 0.25;      // remaining squared length below which a split is repeated
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kFarthest = 100;  // acceptable motion out of overlaps, in multiples of the deepest

double square(double x) {
  return x * x;
}

void turn(double& a, double& b, double c, double s) {
  const double turned = c * a + s * b;
  b = c * b - s * a;
  a = turned;
}

/// The active rows in coordinates y: their normals as Q R, with bounds b and multipliers u.
struct ActiveSet {
  size_t n = 0;
  std::array<int, 6> row{};
  std::array<Vec6, 6> q{}, R{};  // by columns
  Vec6 b{}, u{};
  Vec6 per{};  // 1/R[j][j]: a division costs as much as four products

  /// Splits a vector into coordinates in the columns of Q and the remainder `left`. All columns at
  /// once, without dependent steps; repeated if digits cancelled.
  Vec6 split(Vec6& left) const {
    Vec6 sum{};
    const double before = dot(left, left);
    for (int pass = 0; pass < 2; ++pass) {
      Vec6 c{};
      for (size_t j = 0; j < n; ++j) c[j] = dot(q[j], left);
      for (size_t j = 0; j < n; ++j) add_scaled(left, -c[j], q[j]);
      add_scaled(sum, 1, c);
      if (dot(left, left) > kCancelled * before) break;
    }
    return sum;
  }

  /// R⁻¹ c.
  Vec6 in_rows(Vec6 c) const {
    for (size_t j = n; j-- > 0;) {
      c[j] *= per[j];
      for (size_t i = 0; i < j; ++i) c[i] -= R[j][i] * c[j];
    }
    return c;
  }

  /// Adds a row, from the `split` of its normal.
  void take_in(int index, double bound, const Vec6& along, const Vec6& left) {
    HAPTIC_ASSERT(n < row.size());
    row[n] = index, b[n] = bound;
    R[n] = along;
    R[n][n] = std::sqrt(dot(left, left));
    per[n] = 1 / R[n][n];
    q[n] = {};
    add_scaled(q[n], per[n], left);
    ++n;
  }

  /// Drops row j; rotations of pairs of columns of Q make R triangular again.
  void give_up(size_t j) {
    HAPTIC_ASSERT(j < n);
    --n;
    for (size_t k = j; k < n; ++k) {
      row[k] = row[k + 1], b[k] = b[k + 1], u[k] = u[k + 1], R[k] = R[k + 1];
    }
    for (size_t k = j; k < n; ++k) {
      per[k] = 1 / std::sqrt(square(R[k][k]) + square(R[k][k + 1]));
      const double c = R[k][k] * per[k], s = R[k][k + 1] * per[k];
      for (size_t m = k; m < n; ++m) turn(R[m][k], R[m][k + 1], c, s);
      for (size_t i = 0; i < 6; ++i) turn(q[k][i], q[k + 1][i], c, s);
    }
  }

  /// The point nearest to y_u on all rows and its multipliers: y = (1 − Q Qᵀ) y_u + Q c, Rᵀ c = b,
  /// u = R⁻¹ (c − Qᵀ y_u). If all bounds are zero, nearly dependent rows (a small R) cost y no
  /// accuracy.
  Vec6 nearest_point(const Vec6& y_u) {
    Vec6 y = y_u;
    const Vec6 along = split(y);
    Vec6 c{};
    for (size_t j = 0; j < n; ++j) {
      double sum = b[j];
      for (size_t i = 0; i < j; ++i) sum -= R[j][i] * c[i];
      c[j] = sum * per[j];
      add_scaled(y, c[j], q[j]);
      u[j] = c[j] - along[j];
    }
    // rounding may make a zero slightly negative
    u = in_rows(u);
    for (size_t j = 0; j < n; ++j) u[j] = std::max(u[j], 0.0);
    return y;
  }
};

class Solver {
 public:
  Solver(const MotionMetric& metric, const Twist& a_u, std::span<const MotionRow> rows,
         bool relaxed)
      : metric_(metric),
        a_u_(a_u),
        y_u_(coordinates(metric, a_u)),
        rows_(rows),
        relaxed_(relaxed),
        a_(a_u) {
    size_u_ = std::sqrt(dot(y_u_, y_u_));
    for (const MotionRow& row : rows) {
      reach_v_ = std::max(reach_v_, norm_squared(row.J.v));
      reach_w_ = std::max(reach_w_, norm_squared(row.J.w));
      // a maximum would miss NaN, a sum does not
      sum_ += norm_squared(row.J.v) + norm_squared(row.J.w) + std::fabs(row.b);
    }
    reach_v_ = std::sqrt(reach_v_);
    reach_w_ = std::sqrt(reach_w_);
  }

  bool finite() const { return std::isfinite(sum_) && is_finite(a_u_); }

  ConstrainedMotion run(std::span<const int> warm) {
    ConstrainedMotion out;
    while (iterations_ < kMaxIterations && !out.converged && !out.contradictory) {
      const int worst = most_violated(warm);
      if (worst < 0) {
        out.converged = true;
      } else {
        out.contradictory = !satisfy(worst);
      }
    }
    out.a = a_;
    out.n_active = static_cast<int>(set_.n);
    for (size_t j = 0; j < set_.n; ++j) {
      const Twist& J = rows_[static_cast<size_t>(set_.row[j])].J;
      out.active[j] = set_.row[j];
      out.multiplier[j] = set_.u[j];
      out.constraint = out.constraint + set_.u[j] * Wrench{J.v, J.w};
    }
    out.iterations = iterations_;
    return out;
  }

 private:
  double bound(size_t k) const { return relaxed_ ? std::min(rows_[k].b, 0.0) : rows_[k].b; }

  /// Largest violation that may be rounding of the motion or below the rank check.
  double tolerated() const {
    const double speed = reach_v_ * (norm(a_u_.v) + norm(a_.v));
    const double spin = reach_w_ * (norm(a_u_.w) + norm(a_.w));
    return std::max(kFeasible * (speed + spin), indistinct_);
  }

  /// J·a − b plus the rounding of b.
  double slack(size_t k) const {
    const double b = bound(k);
    return dot(rows_[k].J, a_) - b + kFeasible * std::fabs(b);
  }

  /// The first violated row of `warm`, which is consumed; else the most violated of all; else −1.
  int most_violated(std::span<const int>& warm) const {
    double least = -tolerated();
    for (; !warm.empty(); warm = warm.subspan(1)) {
      if (warm[0] < 0 || static_cast<size_t>(warm[0]) >= rows_.size()) continue;
      const auto k = static_cast<size_t>(warm[0]);
      if (slack(k) < least) return warm[0];
    }
    int worst = -1;
    for (size_t k = 0; k < rows_.size(); ++k) {
      const double s = slack(k);
      if (s < least) worst = static_cast<int>(k), least = s;
    }
    return worst;
  }

  /// Moves a onto the row and drops rows that would have to pull. False: no acceptable motion
  /// satisfies it together with the rest.
  bool satisfy(int index) {
    HAPTIC_ASSERT(index >= 0 && static_cast<size_t>(index) < rows_.size());
    const auto k = static_cast<size_t>(index);
    const Twist& J = rows_[k].J;
    const Vec6 g = whitened(metric_, components(J.v, J.w));
    const double length = std::sqrt(dot(g, g));
    const double missing = bound(k) - dot(J, a_);
    bool changed = false;
    double rest = missing;
    for (;;) {
      ++iterations_;
      Vec6 left = g;
      const Vec6 along = set_.split(left);
      const double left2 = dot(left, left);
      const bool dependent = set_.n == 6 || !(left2 > square(kDependentRow * length));
      // the rank check cannot tell so small a violation from zero
      if (dependent && !changed && missing <= 2 * kDependentRow * length * (size_u_ + push_)) {
        indistinct_ = std::max(indistinct_, missing);
        return true;
      }

      // up to where the first multiplier reaches zero
      const Vec6 r = set_.in_rows(along);
      size_t first = set_.n;
      double step = dependent ? kInfinite : rest / left2;
      for (size_t j = 0; j < set_.n; ++j) {
        if (r[j] > 0 && set_.u[j] < step * r[j]) first = j, step = set_.u[j] / r[j];
      }
      if (step == kInfinite) return false;
      changed = true;
      for (size_t j = 0; j < set_.n; ++j) set_.u[j] -= step * r[j];
      if (first == set_.n) return take_in(index, along, left, length);
      if (!dependent) rest -= step * left2;
      set_.give_up(first);
    }
  }

  /// False: the resulting motion is unacceptably large.
  bool take_in(int index, const Vec6& along, const Vec6& left, double length) {
    const double b = bound(static_cast<size_t>(index));
    set_.take_in(index, b, along, left);
    const Vec6 y = set_.nearest_point(y_u_);
    a_ = motion_of(metric_, y);
    push_ = std::max(push_, b / length);
    return dot(y, y) <= square(size_u_ + kFarthest * push_);
  }

  const MotionMetric& metric_;
  const Twist a_u_;
  const Vec6 y_u_;
  const std::span<const MotionRow> rows_;
  const bool relaxed_;
  double reach_v_ = 0, reach_w_ = 0, sum_ = 0;  // largest |J.v| and |J.w|, sum of all
  ActiveSet set_;
  Twist a_;
  double size_u_ = 0;      // |a_u| in the metric
  double push_ = 0;        // largest distance of a = 0 behind the rows added
  double indistinct_ = 0;  // largest violation that the rank check took for zero
  int iterations_ = 0;
};

}  // namespace

ConstrainedMotion least_constraint(const MotionMetric& metric, const Twist& a_u,
                                   std::span<const MotionRow> rows, std::span<const int> warm) {
  Solver solver(metric, a_u, rows, false);
  if (!metric.valid || !solver.finite()) return {};
  ConstrainedMotion out = solver.run(warm);
  if (!out.contradictory) return out;
  const int spent = out.iterations;
  out = Solver(metric, a_u, rows, true).run(warm);
  // a = 0 satisfies these rows, so only rounding can make them contradictory
  out.converged = out.converged && !out.contradictory;
  out.contradictory = true;
  out.iterations += spent;
  return out;
}

}  // namespace haptic

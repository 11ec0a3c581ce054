// SPDX-License-Identifier: Apache-2.0
#include "proto/math/qp.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr int kMaxIterations = 100;   // rows taken in or given up
constexpr double kFeasible = 1e-13;   // violation, relative to what it is the difference of
constexpr double kDependent = 1e-10;  // what is left of a row beside the active ones, relative
constexpr double kFarthest = 100;     // way out of overlaps, times the deepest

/// The rows that carry the motion, in coordinates y: their normals g as Q R, bounds b on g·y and
/// multipliers u.
struct ActiveSet {
  size_t n = 0;
  std::array<int, 6> row{};
  std::array<Vec6, 6> g{}, q{};
  std::array<Vec6, 6> R{};  // by columns
  Vec6 b{}, u{};

  /// Coordinates of a normal in Q, and what is left of it: twice, which makes it orthogonal.
  Vec6 split(Vec6& left, size_t columns) const {
    Vec6 c{};
    for (int pass = 0; pass < 2; ++pass) {
      for (size_t j = 0; j < columns; ++j) {
        const double more = dot(q[j], left);
        c[j] += more;
        add_scaled(left, -more, q[j]);
      }
    }
    return c;
  }

  /// R⁻¹ c.
  Vec6 in_rows(Vec6 c) const {
    for (size_t j = n; j-- > 0;) {
      c[j] /= R[j][j];
      for (size_t i = 0; i < j; ++i) c[i] -= R[j][i] * c[j];
    }
    return c;
  }

  /// Column j of the factors anew from g.
  void factor(size_t j) {
    Vec6 left = g[j];
    R[j] = split(left, j);
    R[j][j] = std::sqrt(dot(left, left));
    for (size_t i = 0; i < 6; ++i) q[j][i] = left[i] / R[j][j];
  }

  void take_in(int index, const Vec6& normal, double bound, double multiplier) {
    row[n] = index, g[n] = normal, b[n] = bound, u[n] = multiplier;
    factor(n++);
  }

  void give_up(size_t j) {
    --n;
    for (size_t k = j; k < n; ++k) {
      row[k] = row[k + 1], g[k] = g[k + 1], b[k] = b[k + 1], u[k] = u[k + 1];
    }
    for (size_t k = j; k < n; ++k) factor(k);
  }

  /// The point nearest to y_u on all of them and the multipliers that put it there:
  /// y = (1 − Q Qᵀ) y_u + Q c, Rᵀ c = b, and u = R⁻¹ (c − Qᵀ y_u). Where all bounds are zero nearly
  /// dependent rows, a small R, cost y no digits.
  Vec6 nearest_point(const Vec6& y_u) {
    Vec6 y = y_u;
    const Vec6 along = split(y, n);
    Vec6 c{};
    for (size_t j = 0; j < n; ++j) {
      double sum = b[j];
      for (size_t i = 0; i < j; ++i) sum -= R[j][i] * c[i];
      c[j] = sum / R[j][j];
      add_scaled(y, c[j], q[j]);
      u[j] = c[j] - along[j];
    }
    // an exact zero may come out a rounding below
    u = in_rows(u);
    for (size_t j = 0; j < n; ++j) u[j] = std::max(u[j], 0.0);
    return y;
  }
};

double square(double x) {
  return x * x;
}

class Solver {
 public:
  Solver(const MotionMetric& metric, const Twist& a_u, std::span<const MotionRow> rows,
         bool relaxed)
      : metric_(metric),
        a_u_(a_u),
        y_u_(coordinates(metric, a_u)),
        rows_(rows),
        relaxed_(relaxed),
        y_(y_u_) {
    for (const MotionRow& row : rows) {
      reach_v_ = std::max(reach_v_, norm_squared(row.J.v));
      reach_w_ = std::max(reach_w_, norm_squared(row.J.w));
      farthest_ = std::max(farthest_, std::fabs(row.b));
      // a maximum passes NaN over, a sum does not
      sum_ += norm_squared(row.J.v) + norm_squared(row.J.w) + std::fabs(row.b);
    }
    reach_v_ = std::sqrt(reach_v_);
    reach_w_ = std::sqrt(reach_w_);
  }

  bool finite() const { return std::isfinite(sum_) && is_finite(a_u_); }

  ConstrainedMotion run(std::span<const int> warm) {
    ConstrainedMotion out;
    for (;;) {
      if (iterations_ >= kMaxIterations) break;
      const int worst = most_violated(warm);
      if (worst < 0) {
        out.converged = true;
        break;
      }
      if (!satisfy(worst)) {
        out.contradictory = true;
        break;
      }
    }
    out.a = motion();
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
  Twist motion() const { return set_.n == 0 ? a_u_ : motion_of(metric_, y_); }

  /// Below this a violation is rounding.
  double noise(const Twist& a) const {
    return kFeasible * (reach_v_ * (norm(a_u_.v) + norm(a.v)) +
                        reach_w_ * (norm(a_u_.w) + norm(a.w)) + farthest_);
  }

  /// A violated row of `warm`, which shrinks, else the most violated of all, else −1.
  int most_violated(std::span<const int>& warm) const {
    const Twist a = motion();
    const double tolerated = std::max(noise(a), indistinct_);
    for (; !warm.empty(); warm = warm.subspan(1)) {
      if (warm[0] < 0 || static_cast<size_t>(warm[0]) >= rows_.size()) continue;
      const auto k = static_cast<size_t>(warm[0]);
      if (dot(rows_[k].J, a) - bound(k) < -tolerated) return warm[0];
    }
    int worst = -1;
    double least = -tolerated;
    for (size_t k = 0; k < rows_.size(); ++k) {
      const double slack = dot(rows_[k].J, a) - bound(k);
      if (slack < least) worst = static_cast<int>(k), least = slack;
    }
    return worst;
  }

  /// Moves y onto the row, giving up those that would have to pull. False where no y within reason
  /// satisfies it together with those that are left.
  bool satisfy(int index) {
    const auto k = static_cast<size_t>(index);
    const Twist& J = rows_[k].J;
    const Vec6 g = whitened(metric_, components(J.v, J.w));
    const double length2 = dot(g, g);
    const double missing = bound(k) - dot(J, motion());
    double slack = -missing, multiplier = 0;
    const ActiveSet before = set_;
    for (;;) {
      ++iterations_;
      Vec6 z = g;
      const Vec6 r = set_.in_rows(set_.split(z, set_.n));
      const double left2 = dot(z, z);
      const bool dependent = set_.n == 6 || !(left2 > kDependent * kDependent * length2);

      // as far as the first multiplier lasts
      size_t first = set_.n;
      double step = 0;
      for (size_t j = 0; j < set_.n; ++j) {
        if (r[j] > 0 && (first == set_.n || set_.u[j] < step * r[j])) {
          first = j;
          step = set_.u[j] / r[j];
        }
      }
      // the rank check cannot tell a violation this small from none
      if (dependent && missing <= 2 * kDependent * std::sqrt(length2 * dot(y_u_, y_u_))) {
        set_ = before;
        indistinct_ = std::max(indistinct_, missing);
        return true;
      }
      if (dependent && first == set_.n) return false;
      const double full = dependent ? step : -slack / left2;
      const bool reaches = !dependent && (first == set_.n || full <= step);
      if (reaches) step = full;
      multiplier += step;
      for (size_t j = 0; j < set_.n; ++j) set_.u[j] -= step * r[j];
      if (reaches) {
        set_.take_in(index, g, bound(k), multiplier);
        y_ = set_.nearest_point(y_u_);
        push_ = std::max(push_, bound(k) / std::sqrt(length2));
        return dot(y_, y_) <= square(std::sqrt(dot(y_u_, y_u_)) + kFarthest * push_);
      }
      if (!dependent) slack += step * left2;
      set_.give_up(first);
    }
  }

  const MotionMetric& metric_;
  const Twist a_u_;
  const Vec6 y_u_;
  const std::span<const MotionRow> rows_;
  const bool relaxed_;
  double reach_v_ = 0, reach_w_ = 0, farthest_ = 0, sum_ = 0;  // largest |J.v|, |J.w|, |b|
  ActiveSet set_;
  Vec6 y_;
  double push_ = 0;        // how far a = 0 is behind the rows taken in, at most
  double indistinct_ = 0;  // the largest violation that the rank check took for none
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
  // rows that a = 0 satisfies contradict one another by rounding alone
  out.converged = out.converged && !out.contradictory;
  out.contradictory = true;
  out.iterations += spent;
  return out;
}

}  // namespace haptic

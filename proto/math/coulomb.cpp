// SPDX-License-Identifier: Apache-2.0
#include "proto/math/coulomb.h"

#include <algorithm>
#include <limits>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int kMaxRounds = 60;      // of the fixed point
constexpr int kMaxCuts = 60;        // rounds of cutting planes in each of these
constexpr double kWanted = 1e-12;   // relative tolerance of cones and of the change per round
constexpr double kAccepted = 1e-8;  // accepted where rounding stops both from shrinking
constexpr double kRounder = 1e-5;   // tolerance of cones, relative to the last change
constexpr double kWorst = 0.5;      // cones are cut if violated by at least this share of the worst
constexpr double kMuchWorse = 10;   // growth of the residual that resets Broyden's estimate

double norm(const Vec6& y) {
  return std::sqrt(dot(y, y));
}

Vec6 difference(Vec6 a, const Vec6& b) {
  add_scaled(a, -1, b);
  return a;
}

/// Broyden's first method for Φ(y) = y: estimates the inverse of 1 − Φ′ from secants.
class Broyden {
 public:
  /// Next point to evaluate, given Φ(y) − y = residual at y.
  Vec6 next(const Vec6& y, const Vec6& residual) {
    if (asked_) {
      const Vec6 dy = difference(y, y_), dr = difference(residual_, residual);
      const Vec6 mapped = inverse_ * dr, left = multiply_transposed(dy);
      const double denominator = dot(dy, mapped);
      // after a much larger residual or a degenerate secant: plain iteration again
      if (norm(residual) >= kMuchWorse * norm(residual_) ||
          !(std::fabs(denominator) > 1e-6 * dot(dy, dy))) {
        inverse_ = identity();
      } else {
        const Vec6 gain = difference(dy, mapped);
        for (size_t i = 0; i < 6; ++i) {
          for (size_t j = 0; j < 6; ++j) inverse_(i, j) += gain[i] * left[j] / denominator;
        }
      }
    }
    y_ = y, residual_ = residual, asked_ = true;
    Vec6 ahead = y;
    add_scaled(ahead, 1, inverse_ * residual);
    return ahead;
  }

 private:
  static Mat6 identity() {
    Mat6 one;
    for (size_t i = 0; i < 6; ++i) one(i, i) = 1;
    return one;
  }
  Vec6 multiply_transposed(const Vec6& x) const {
    Vec6 out{};
    for (size_t i = 0; i < 6; ++i) {
      for (size_t j = 0; j < 6; ++j) out[j] += inverse_(i, j) * x[i];
    }
    return out;
  }

  Mat6 inverse_ = identity();
  Vec6 y_{}, residual_{};
  bool asked_ = false;
};

/// True if a relative error has reached `wanted`, or is small and no longer shrinks.
bool settled(double error, double before, double wanted) {
  return error <= wanted || (error <= kAccepted && error > before / 2);
}

/// Velocity of the contact relative to the obstacle, normal and tangential.
struct PointVelocity {
  double normal = 0;
  Vec3 tangential;
};
PointVelocity velocity_of(const FrictionContact& contact, const Twist& v) {
  const Vec3 u = velocity_at(v, contact.r) - contact.obstacle_velocity;
  const double along = dot(contact.normal, u);
  return {along, u - along * contact.normal};
}

}  // namespace

FrictionStep CoulombSolver::step(const MotionMetric& metric, const Twist& v_free,
                                 std::span<const FrictionContact> contacts, int max_solves) {
  FrictionStep out;
  if (contacts.size() > capacity_ || !metric.valid) return out;
  metric_ = &metric, v_free_ = v_free, contacts_ = contacts;
  n_rows_ = n_warm_ = 0;
  std::fill_n(impulses_.begin(), contacts.size(), Vec3{});
  out.impulses = {impulses_.data(), contacts.size()};
  speed_ = 0;
  double sum = 0;
  for (const FrictionContact& c : contacts) {
    const double relative = norm(velocity_at(v_free, c.r)) + norm(c.obstacle_velocity);
    speed_ = std::max(speed_, relative + std::fabs(c.least_speed));
    sum += norm_squared(c.r) + norm_squared(c.normal) + c.friction + relative +
           std::fabs(c.least_speed);
  }
  if (!std::isfinite(sum) || !is_finite(v_free)) return out;

  ConstrainedMotion motion = solve_cones({}, kRounder, out);
  const double size =
      std::max(norm(coordinates(metric, v_free)), std::numeric_limits<double>::min());
  Twist asked = motion.a;
  double moved = 1;
  Broyden broyden;
  while (!out.converged && motion.converged && out.iterations < kMaxRounds &&
         out.solves < max_solves) {
    ++out.iterations;
    // early rounds need no more accurate cones than their own error
    const double rounder = std::clamp(kRounder * moved, kWanted, kRounder);
    motion = solve_cones(asked, rounder, out);
    const Vec6 y = coordinates(metric, asked);
    const Vec6 residual = difference(coordinates(metric, motion.a), y);
    const double before = moved;
    moved = norm(residual) / size;
    // where nothing changes, cones this inaccurate hide that it would
    out.converged = motion.converged && settled(moved, before, kWanted) && rounder <= kWanted;
    asked = motion_of(metric, broyden.next(y, residual));
  }
  if (!out.converged) motion = solve_cones({}, kWanted, out);
  add_up(motion, out);
  return out;
}

/// The twist nearest to v_free in all cones, each shifted by μ |u_t| of `shift_of`.
ConstrainedMotion CoulombSolver::solve_cones(const Twist& shift_of, double wanted,
                                             FrictionStep& out) {
  for (size_t i = 0; i < contacts_.size(); ++i) {
    const FrictionContact& c = contacts_[i];
    HAPTIC_ASSERT(c.friction >= 0);
    shifts_[i] = c.friction * norm(velocity_of(c, shift_of).tangential);
  }
  for (size_t k = 0; k < n_rows_; ++k) {
    rows_[k].b = bound_of(rows_[k].J.v, owners_[k]);
  }
  ConstrainedMotion motion;
  double lack = speed_;
  for (int cut = 0; cut < kMaxCuts; ++cut) {
    motion = least_constraint(*metric_, v_free_, rows(), {warm_.data(), n_warm_});
    ++out.solves;
    if (n_rows_ + contacts_.size() > rows_.size()) keep_active(motion);
    warm_ = motion.active, n_warm_ = static_cast<size_t>(motion.n_active);
    const double before = lack;
    lack = worst_lack(motion.a);
    if (!motion.converged || !(lack > 0) || settled(lack / speed_, before / speed_, wanted))
      return motion;
    cut_cones(motion.a, lack);
  }
  motion.converged = false;
  return motion;
}

/// Largest violation of a cone by v [m/s].
double CoulombSolver::worst_lack(const Twist& v) {
  double worst = 0;
  for (size_t i = 0; i < contacts_.size(); ++i) {
    const FrictionContact& c = contacts_[i];
    const PointVelocity u = velocity_of(c, v);
    lacks_[i] = c.friction * norm(u.tangential) - shifts_[i] + c.least_speed - u.normal;
    worst = std::max(worst, lacks_[i]);
  }
  return worst;
}

/// Adds cutting planes to the cones that v violates most.
void CoulombSolver::cut_cones(const Twist& v, double worst) {
  for (size_t i = 0; i < contacts_.size(); ++i) {
    if (lacks_[i] < kWorst * worst) continue;
    const FrictionContact& c = contacts_[i];
    const Vec3 force = c.normal - c.friction * normalized(velocity_of(c, v).tangential);
    HAPTIC_ASSERT(n_rows_ < rows_.size());
    rows_[n_rows_] = {{force, cross(c.r, force)}, bound_of(force, i)};
    owners_[n_rows_] = i;
    ++n_rows_;
  }
}

/// Bound of the row `direction`, a unit normal plus a tangential part, at contact i.
double CoulombSolver::bound_of(const Vec3& direction, size_t i) const {
  HAPTIC_ASSERT(i < contacts_.size());
  const FrictionContact& c = contacts_[i];
  return c.least_speed - shifts_[i] + dot(direction, c.obstacle_velocity);
}

/// Drops inactive cutting planes.
void CoulombSolver::keep_active(ConstrainedMotion& motion) {
  const auto n = static_cast<size_t>(motion.n_active);
  HAPTIC_ASSERT(n <= 6);
  std::array<MotionRow, 6> rows;
  std::array<size_t, 6> owners{};
  for (size_t j = 0; j < n; ++j) {
    const auto k = static_cast<size_t>(motion.active[j]);
    rows[j] = rows_[k], owners[j] = owners_[k];
    motion.active[j] = static_cast<int>(j);
  }
  std::copy_n(rows.begin(), n, rows_.begin());
  std::copy_n(owners.begin(), n, owners_.begin());
  n_rows_ = n;
}

void CoulombSolver::add_up(const ConstrainedMotion& motion, FrictionStep& out) {
  for (size_t j = 0; j < static_cast<size_t>(motion.n_active); ++j) {
    const auto k = static_cast<size_t>(motion.active[j]);
    impulses_[owners_[k]] += motion.multiplier[j] * rows_[k].J.v;
  }
  out.v = motion.a;
  out.impulse = motion.constraint;
  out.contradictory = motion.contradictory;
}

}  // namespace haptic

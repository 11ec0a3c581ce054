// SPDX-License-Identifier: Apache-2.0
#include "proto/math/lcp.h"

#include <algorithm>
#include <limits>

#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kRounding = 1e-11;          // of a, relative to the terms it is the sum of
constexpr double kDependent = 1e-9;          // response to a unit force, relative to A_dd
constexpr double kSettled = 1e-13;           // change of an a in a sweep, relative likewise
constexpr double kAcceptedResidual = 1e-10;  // residual of a, relative to b
constexpr int kPivotsPerRow = 20;            // pivot limit per row; a handful is usual

}  // namespace

LcpSolution LcpSolver::solve(LcpMethod method, std::span<const double> A, std::span<const double> b,
                             int max_sweeps) {
  HAPTIC_ASSERT(max_sweeps >= 0);
  n_ = b.size();
  if (n_ > capacity_ || A.size() != n_ * n_) return {};
  A_ = A, b_ = b;
  largest_A_ = largest_b_ = 0;
  double sum = 0;
  for (const double x : b) largest_b_ = std::max(largest_b_, std::fabs(x)), sum += std::fabs(x);
  for (const double x : A) largest_A_ = std::max(largest_A_, std::fabs(x)), sum += std::fabs(x);
  std::fill_n(f_.begin(), n_, 0.0);
  std::copy(b.begin(), b.end(), a_.begin());
  LcpSolution out{{f_.data(), n_}, {a_.data(), n_}};
  if (!std::isfinite(sum)) return out;
  out.converged =
      method == LcpMethod::kPivoting ? pivot(out.iterations) : sweep(max_sweeps, out.iterations);
  return out;
}

ImpulseStep LcpSolver::step(LcpMethod method, const MotionMetric& metric, const Twist& v_free,
                            std::span<const MotionRow> rows, int max_sweeps) {
  ImpulseStep out;
  out.v = v_free;
  const size_t n = rows.size();
  if (n > capacity_ || !metric.valid || !is_finite(v_free)) return out;
  for (size_t i = 0; i < n; ++i) {
    g_[i] = whitened(metric, components(rows[i].J.v, rows[i].J.w));
    own_b_[i] = dot(rows[i].J, v_free) - rows[i].b;
    for (size_t j = 0; j <= i; ++j) {
      own_A_[i * n + j] = own_A_[j * n + i] = dot(g_[i], g_[j]);
    }
  }
  const LcpSolution lcp = solve(method, {own_A_.data(), n * n}, {own_b_.data(), n}, max_sweeps);
  out.lambda = lcp.f;
  out.converged = lcp.converged;
  out.iterations = lcp.iterations;
  if (!lcp.converged) return out;
  Vec6 y{};
  for (size_t i = 0; i < n; ++i) add_scaled(y, lcp.f[i], g_[i]);
  out.v = v_free + motion_of(metric, y);
  return out;
}

/// Rounding error of an a_i; smaller values mean zero.
double LcpSolver::noise() const {
  double forces = 0;
  for (size_t i = 0; i < n_; ++i) forces += std::fabs(f_[i]);
  return kRounding * (largest_b_ + largest_A_ * forces);
}

void LcpSolver::update_a() {
  for (size_t i = 0; i < n_; ++i) {
    a_[i] = b_[i];
    for (size_t j = 0; j < n_; ++j) a_[i] += entry(i, j) * f_[j];
  }
}

bool LcpSolver::pivot(int& iterations) {
  n_clamped_ = 0;
  std::fill_n(side_.begin(), n_, Side::kUnseen);
  for (size_t d = 0; d < n_; ++d) {
    if (!drive_to_zero(d, iterations)) return false;
    if (side_[d] == Side::kUnseen) side_[d] = Side::kOpen;
  }
  // removes the rounding accumulated over the steps from a_C
  update_a();
  for (size_t k = 0; k < n_clamped_; ++k) x_[k] = -a_[clamped_[k]];
  solve_clamped({x_.data(), n_clamped_});
  for (size_t k = 0; k < n_clamped_; ++k) {
    f_[clamped_[k]] = std::max(f_[clamped_[k]] + x_[k], 0.0);
  }
  update_a();
  return is_solved();
}

/// True if the result is a solution: rounding may have chosen the sets, or there may be none.
bool LcpSolver::is_solved() const {
  const double tolerated = kAcceptedResidual * largest_b_ + kSettled / kRounding * noise();
  for (size_t i = 0; i < n_; ++i) {
    if (!(a_[i] >= -tolerated) || (f_[i] > 0 && !(a_[i] <= tolerated))) return false;
  }
  return true;
}

bool LcpSolver::drive_to_zero(size_t d, int& iterations) {
  // if a tie brought a_d to zero before d could enter C, its force enters C or is withdrawn
  while (a_[d] < -noise() || f_[d] > 0) {
    if (++iterations > kPivotsPerRow * static_cast<int>(n_ + 1)) return false;
    find_direction(d);
    const bool independent = da_[d] > kDependent * entry(d, d);
    const bool give_back = a_[d] >= -noise();
    if (give_back && independent) {
      enter(d);
      return true;
    }
    if (give_back) reverse();
    size_t first = give_back || independent ? d : n_;
    double step = give_back     ? f_[d]
                  : independent ? -a_[d] / da_[d]
                                : std::numeric_limits<double>::infinity();
    first = first_event(d, first, step);
    if (first == n_) return false;
    for (size_t i = 0; i < n_; ++i) f_[i] += step * df_[i], a_[i] += step * da_[i];
    if (first == d && give_back) {
      f_[d] = 0;
      return true;
    }
    if (side_[first] == Side::kClamped) {
      leave(first);
    } else {
      enter(first);
      if (first == d) return true;
    }
  }
  return true;
}

/// The first index to change sides within `step`, which is shortened to that; else `first`.
size_t LcpSolver::first_event(size_t d, size_t first, double& step) const {
  for (size_t i = 0; i < n_; ++i) {
    if (side_[i] == Side::kUnseen) continue;
    const bool clamped = side_[i] == Side::kClamped;
    const double tolerated =
        clamped ? kDependent : kDependent * std::sqrt(entry(i, i) * entry(d, d));
    const double value = clamped ? f_[i] : a_[i], change = clamped ? df_[i] : da_[i];
    if (change >= -tolerated) continue;
    const double until = std::max(-value / change, 0.0);
    if (until < step) first = i, step = until;
  }
  return first;
}

void LcpSolver::reverse() {
  for (size_t i = 0; i < n_; ++i) df_[i] = -df_[i], da_[i] = -da_[i];
}

/// Δf with Δf_d = 1 and Δa_C = 0, and Δa = A Δf.
void LcpSolver::find_direction(size_t d) {
  HAPTIC_ASSERT(d < n_ && side_[d] != Side::kClamped);
  std::fill_n(df_.begin(), n_, 0.0);
  for (size_t k = 0; k < n_clamped_; ++k) x_[k] = -entry(clamped_[k], d);
  solve_clamped({x_.data(), n_clamped_});
  for (size_t k = 0; k < n_clamped_; ++k) df_[clamped_[k]] = x_[k];
  df_[d] = 1;
  for (size_t i = 0; i < n_; ++i) {
    da_[i] = entry(i, d);
    for (const size_t k : clamped_set()) da_[i] += entry(i, k) * df_[k];
  }
  for (const size_t k : clamped_set()) da_[k] = 0;
}

void LcpSolver::enter(size_t i) {
  HAPTIC_ASSERT(i < n_ && n_clamped_ < n_);
  a_[i] = 0;
  side_[i] = Side::kClamped;
  clamped_[n_clamped_++] = i;
  factor_from(n_clamped_ - 1);
}

void LcpSolver::leave(size_t i) {
  f_[i] = 0;
  side_[i] = Side::kOpen;
  const std::span<size_t> all = clamped_set();
  const auto place = std::find(all.begin(), all.end(), i);
  HAPTIC_ASSERT(place != all.end());
  const auto k = static_cast<size_t>(place - all.begin());
  std::copy(place + 1, all.end(), place);
  --n_clamped_;
  factor_from(k);
}

/// Computes the rows of the Cholesky factor of A_CC from `place` on.
void LcpSolver::factor_from(size_t place) {
  for (size_t i = place; i < n_clamped_; ++i) {
    double* row = &L_[i * n_];
    for (size_t j = 0; j <= i; ++j) {
      const double* other = &L_[j * n_];
      double sum = entry(clamped_[i], clamped_[j]);
      for (size_t k = 0; k < j; ++k) sum -= row[k] * other[k];
      row[j] = j < i ? sum / other[j] : std::sqrt(sum);
    }
  }
}

/// x ← A_CC⁻¹ x.
void LcpSolver::solve_clamped(std::span<double> x) const {
  HAPTIC_ASSERT(x.size() <= n_clamped_);
  for (size_t i = 0; i < x.size(); ++i) {
    for (size_t k = 0; k < i; ++k) x[i] -= L_[i * n_ + k] * x[k];
    x[i] /= L_[i * n_ + i];
  }
  for (size_t i = x.size(); i-- > 0;) {
    for (size_t k = i + 1; k < x.size(); ++k) x[i] -= L_[k * n_ + i] * x[k];
    x[i] /= L_[i * n_ + i];
  }
}

bool LcpSolver::sweep(int max_sweeps, int& iterations) {
  while (iterations < max_sweeps) {
    ++iterations;
    double largest = 0;
    for (size_t i = 0; i < n_; ++i) {
      if (!(entry(i, i) > 0)) continue;
      double a = b_[i];
      for (size_t j = 0; j < n_; ++j) a += entry(i, j) * f_[j];
      const double before = f_[i];
      f_[i] = std::max(0.0, before - a / entry(i, i));
      largest = std::max(largest, std::fabs(f_[i] - before) * entry(i, i));
    }
    if (largest > kSettled / kRounding * noise()) continue;
    update_a();
    return is_solved();
  }
  update_a();
  return false;
}

}  // namespace haptic

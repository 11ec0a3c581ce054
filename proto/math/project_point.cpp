// SPDX-License-Identifier: Apache-2.0
#include "proto/math/project_point.h"

#include <algorithm>

#include "proto/math/assert.h"
#include "proto/math/mat3.h"

namespace haptic {
namespace {

constexpr int kMostHalfSpaces = 64;  // half-spaces added
// squared sine (two) or squared volume (three) of normals
constexpr double kSingularNormals = 1e-10;
constexpr double kFeasibility = 1e-13;  // relative to the size of the coordinates

using Subset = std::array<int, 3>;

/// Multipliers that put x = p + Σ λ_i n_i on all planes of the subset: N Nᵀ λ = d − N p. False: the
/// normals are dependent.
bool solve_multipliers(std::span<const HalfSpace> h, const Vec3& p, const Subset& subset, int size,
                       std::array<double, 3>& lambda) {
  HAPTIC_ASSERT(size >= 1 && size <= 3);
  std::array<Vec3, 3> n{};
  std::array<double, 3> gap{};
  for (int i = 0; i < size; ++i) {
    const HalfSpace& plane = h[static_cast<size_t>(subset[static_cast<size_t>(i)])];
    n[static_cast<size_t>(i)] = plane.normal;
    gap[static_cast<size_t>(i)] = plane.offset - dot(plane.normal, p);
  }
  if (size == 1) {
    lambda = {gap[0], 0, 0};
    return true;
  }
  if (size == 2) {
    const Vec3 across = cross(n[0], n[1]);
    const double sine2 = norm_squared(across);
    if (sine2 < kSingularNormals) return false;
    const double cosine = dot(n[0], n[1]);
    lambda = {(gap[0] - cosine * gap[1]) / sine2, (gap[1] - cosine * gap[0]) / sine2, 0};
    return true;
  }
  // three planes meet in a point: Cramer's rule, then its coordinates in the normals
  const double volume = dot(n[0], cross(n[1], n[2]));
  if (volume * volume < kSingularNormals) return false;
  const Vec3 c12 = cross(n[1], n[2]), c20 = cross(n[2], n[0]), c01 = cross(n[0], n[1]);
  const Vec3 step = (gap[0] * c12 + gap[1] * c20 + gap[2] * c01) / volume;
  lambda = {dot(step, c12) / volume, dot(step, c20) / volume, dot(step, c01) / volume};
  return true;
}

/// Nearest point to p on all planes of the subset, x = p + Σ λ_i n_i. For nearly opposite normals
/// two huge multipliers almost cancel; a second pass restores the lost digits.
bool lagrange_point(std::span<const HalfSpace> h, const Vec3& p, const Subset& subset, int size,
                    Vec3& x, std::array<double, 3>& lambda) {
  x = p;
  lambda = {};
  for (int pass = 0; pass < 2; ++pass) {
    std::array<double, 3> step{};
    if (!solve_multipliers(h, x, subset, size, step)) return false;
    for (size_t i = 0; i < static_cast<size_t>(size); ++i) {
      x += step[i] * h[static_cast<size_t>(subset[i])].normal;
      lambda[i] += step[i];
    }
  }
  return true;
}

double slack(const HalfSpace& h, const Vec3& x) {
  return dot(h.normal, x) - h.offset;
}

/// Finds the subset of `pool` that contains its last member and satisfies the KKT conditions for
/// the pool's half-spaces.
bool exchange(std::span<const HalfSpace> h, const Vec3& p, std::span<const int> pool,
              double tolerance, PointProjection& out) {
  HAPTIC_ASSERT(!pool.empty() && pool.size() <= 4);
  const int entering = pool.back();
  const size_t others = pool.size() - 1;
  bool found = false;
  for (unsigned mask = 0; mask < (1u << others); ++mask) {
    Subset subset{entering, 0, 0};
    int size = 1;
    for (size_t i = 0; i < others && size <= 3; ++i) {
      if ((mask >> i & 1u) == 0) continue;
      if (size < 3) subset[static_cast<size_t>(size)] = pool[i];
      ++size;
    }
    Vec3 x;
    std::array<double, 3> lambda{};
    if (size > 3 || !lagrange_point(h, p, subset, size, x, lambda)) continue;
    if (*std::min_element(lambda.begin(), lambda.begin() + size) < 0) continue;
    const bool feasible = std::all_of(pool.begin(), pool.end(), [&](int i) {
      return slack(h[static_cast<size_t>(i)], x) >= -tolerance;
    });
    // ties (degenerate vertices) go to the nearer point, then to the smaller subset
    if (!feasible || (found && norm_squared(x - p) >= norm_squared(out.x - p))) continue;
    out.x = x;
    out.n_active = size;
    out.active = subset;
    out.multiplier = lambda;
    found = true;
  }
  return found;
}

}  // namespace

PointProjection project_onto_half_spaces(const Vec3& p, std::span<const HalfSpace> half_spaces) {
  PointProjection out;
  out.x = p;
  double scale = norm(p);
  for (const HalfSpace& h : half_spaces) scale = std::max(scale, std::fabs(h.offset));
  const double tolerance = kFeasibility * scale;

  for (; out.iterations < kMostHalfSpaces; ++out.iterations) {
    int worst = -1;
    double worst_slack = -tolerance;
    for (size_t i = 0; i < half_spaces.size(); ++i) {
      const double s = slack(half_spaces[i], out.x);
      // written so that NaN counts as violated, and the result says so
      if (!(s >= worst_slack)) worst = static_cast<int>(i), worst_slack = s;
    }
    if (worst < 0) return out;

    HAPTIC_ASSERT(out.n_active <= 3);
    std::array<int, 4> pool{};
    std::copy_n(out.active.begin(), out.n_active, pool.begin());
    pool[static_cast<size_t>(out.n_active)] = worst;
    const auto pool_size = static_cast<size_t>(out.n_active) + 1;
    if (!exchange(half_spaces, p, std::span<const int>(pool.data(), pool_size), tolerance, out)) {
      break;
    }
  }
  out.converged = false;
  return out;
}

}  // namespace haptic

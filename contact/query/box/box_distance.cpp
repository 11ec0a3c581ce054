// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/box/box_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// relative error: float axes are orthonormal to 5e-6, which oblique axes amplify five-fold
constexpr float kSlack = 5e-5F;
constexpr double kRounding = 1e-14;   // relative error of positions in double
constexpr float kLeastSine2 = 0.04F;  // sin² of the angle below which axes count as parallel

Lanes everywhere(float x) {
  return Lanes{x, x, x, x};
}
template <int k>
Lanes lane(Lanes v) {
  return __builtin_shufflevector(v, v, k, k, k, k);
}
/// Σ columnₖ vₖ.
Lanes turned(const Lanes* columns, Lanes v) {
  return columns[0] * lane<0>(v) + columns[1] * lane<1>(v) + columns[2] * lane<2>(v);
}
Lanes positive(Lanes v) {
  return v > 0 ? v : Lanes{};
}
float sum(Lanes v) {
  return v[0] + v[1] + v[2];
}
Vec3 centre_of(const CompactObb& box) {
  return {box.centre_O[0], box.centre_O[1], box.centre_O[2]};
}

/// v[1], v[2], v[0] and v[2], v[0], v[1].
Lanes next(Lanes v) {
  return __builtin_shufflevector(v, v, 1, 2, 0, 3);
}
Lanes after_next(Lanes v) {
  return __builtin_shufflevector(v, v, 2, 0, 1, 3);
}

/// Largest squared gap along axis i of a crossed with the axes of b; rows[i][j]: component of axis
/// i along axis j.
template <int i>
Lanes gap2_across(Lanes t, Lanes h, Lanes g, const Lanes* rows) {
  constexpr int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
  const Lanes row = magnitude(rows[i]);
  const Lanes along = magnitude(lane<i2>(t) * rows[i1] - lane<i1>(t) * rows[i2]);
  const Lanes reach = lane<i1>(h) * magnitude(rows[i2]) + lane<i2>(h) * magnitude(rows[i1]) +
                      next(g) * after_next(row) + after_next(g) * next(row);
  const Lanes gap = positive(along - reach), sine2 = 1 - row * row;
  return sine2 > kLeastSine2 ? gap * gap / sine2 : Lanes{};
}

}  // namespace

/// A box as vectors; the fourth lane is unused.
struct BoxLanes {
  Lanes columns[3], half;

  explicit BoxLanes(const CompactObb& box) {
    const auto* bytes = reinterpret_cast<const char*>(&box);
    static_assert(offsetof(CompactObb, half) == 9 * sizeof(float));
    for (int k = 0; k < 3; ++k) columns[k] = load_lanes<Lanes>(bytes + 3 * sizeof(float) * k);
    half = load_lanes<Lanes>(bytes + offsetof(CompactObb, half));
  }
};

BoxDistance::BoxDistance(const Pose& X_AB)
    : R_AB_(to_matrix(X_AB.q)), p_AB_(X_AB.p), rounding_(kRounding * norm(X_AB.p)) {
  HAPTIC_ASSERT(is_unit(X_AB.q));
  for (int k = 0; k < 3; ++k) {
    columns_AB_[k] = to_lanes(R_AB_.column(k));
  }
}

/// The gaps of two boxes along all axes.
struct BoxDistance::Gaps {
  BoxLanes box_a;
  Lanes t, r[3], rows[3];               // from a to b in a's axes; b's axes in a's, and a's in b's
  Lanes t_b, gap_a, gap_b;              // from a to b in b's axes; gaps along faces
  Lanes across[3];                      // squared, along axis i of a crossed with those of b
  float faces_a, faces_b, most_across;  // squared
  double at_least;

  Vec3 way_A() const;
};

/// From centre to centre, in A [m].
Vec3 BoxDistance::way_between(const CompactObb& a, const CompactObb& b) const {
  return p_AB_ + R_AB_ * centre_of(b) - centre_of(a);
}

/// Error of a distance computed in float [m].
double BoxDistance::rounding_of(const CompactObb& a, const CompactObb& b) const {
  const float size = a.half[0] + a.half[1] + a.half[2] + b.half[0] + b.half[1] + b.half[2];
  return static_cast<double>(kSlack * size) +
         kRounding * (norm(centre_of(a)) + norm(centre_of(b))) + rounding_;
}

BoxDistance::Gaps BoxDistance::gaps(const CompactObb& a, const CompactObb& b) const {
  const Vec3 way = way_between(a, b);
  const BoxLanes box_a(a), box_b(b);
  const Lanes h = box_a.half, g = box_b.half;
  const Lanes t = box_a.columns[0] * everywhere(static_cast<float>(way.x)) +
                  box_a.columns[1] * everywhere(static_cast<float>(way.y)) +
                  box_a.columns[2] * everywhere(static_cast<float>(way.z));
  // b's axes in a's: r[j][i]
  Lanes r[3];
  for (int j = 0; j < 3; ++j) {
    const Lanes axis{box_b.columns[0][j], box_b.columns[1][j], box_b.columns[2][j], 0};
    r[j] = turned(box_a.columns, turned(columns_AB_, axis));
  }
  const Lanes rows[3] = {{r[0][0], r[1][0], r[2][0], 0},
                         {r[0][1], r[1][1], r[2][1], 0},
                         {r[0][2], r[1][2], r[2][2], 0}};
  const Lanes reach_b =
      magnitude(r[0]) * lane<0>(g) + magnitude(r[1]) * lane<1>(g) + magnitude(r[2]) * lane<2>(g);
  const Lanes reach_a = magnitude(rows[0]) * lane<0>(h) + magnitude(rows[1]) * lane<1>(h) +
                        magnitude(rows[2]) * lane<2>(h);
  const Lanes t_b = turned(rows, t);
  const Lanes gap_a = positive(magnitude(t) - h - reach_b);
  const Lanes gap_b = positive(magnitude(t_b) - g - reach_a);
  const float faces_a = sum(gap_a * gap_a), faces_b = sum(gap_b * gap_b);
  const Lanes c0 = gap2_across<0>(t, h, g, rows), c1 = gap2_across<1>(t, h, g, rows),
              c2 = gap2_across<2>(t, h, g, rows);
  Lanes most = c0 > c1 ? c0 : c1;
  most = most > c2 ? most : c2;
  const float across = std::max({most[0], most[1], most[2]});
  const double gap = (1 - static_cast<double>(kSlack)) *
                     std::sqrt(static_cast<double>(std::max({faces_a, faces_b, across})));
  return {box_a,
          t,
          {r[0], r[1], r[2]},
          {rows[0], rows[1], rows[2]},
          t_b,
          gap_a,
          gap_b,
          {c0, c1, c2},
          faces_a,
          faces_b,
          across,
          std::max(gap - rounding_of(a, b), 0.0)};
}

/// Direction of the largest gap: between a box and the box around the other, or a cross product of
/// two axes.
Vec3 BoxDistance::Gaps::way_A() const {
  const auto with_sign_of = [](Lanes size, Lanes v) { return v < 0 ? -size : size; };
  Lanes way = with_sign_of(gap_a, t);  // in a's axes
  if (faces_b > faces_a) way = turned(r, with_sign_of(gap_b, t_b));
  if (most_across > std::max(faces_a, faces_b)) {
    int i = 0, j = 0;
    for (int k = 0; k < 9; ++k) {
      if (across[k / 3][k % 3] == most_across) i = k / 3, j = k % 3;
    }
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    way = Lanes{};
    way[i1] = -r[j][i2];
    way[i2] = r[j][i1];
    if (sum(way * t) < 0) way = -way;
  }
  Vec3 way_A;
  double* out[3] = {&way_A.x, &way_A.y, &way_A.z};
  for (int k = 0; k < 3; ++k) *out[k] = static_cast<double>(sum(box_a.columns[k] * way));
  return way_A;
}

double BoxDistance::at_least(const CompactObb& a, const CompactObb& b) const {
  return gaps(a, b).at_least;
}

BoxDistance::Separation BoxDistance::separation(const CompactObb& a, const CompactObb& b) const {
  const Gaps known = gaps(a, b);
  if (!(known.at_least > 0)) return {};
  return {known.at_least, known.way_A()};
}

double BoxDistance::along(const Vec3& normal_A, const CompactObb& a, const CompactObb& b) const {
  const BoxLanes box_a(a), box_b(b);
  const Lanes n_a = turned(box_a.columns, to_lanes(normal_A)),
              n_b = turned(box_b.columns, to_lanes(transpose(R_AB_) * normal_A));
  const float reach = sum(box_a.half * magnitude(n_a)) + sum(box_b.half * magnitude(n_b));
  return dot(normal_A, way_between(a, b)) - static_cast<double>(reach) - rounding_of(a, b);
}

}  // namespace haptic

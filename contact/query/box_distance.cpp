// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/box_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace haptic {
namespace {

// axes in floats are orthonormal to 5e-6, which slanting axes show five times as large
constexpr float kSlack = 5e-5F;
constexpr double kRounding = 1e-14;
constexpr float kLeastSine2 = 0.04F;  // of axes that are no longer nearly parallel

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

/// A box in lanes; the fourth lane is never looked at.
struct BoxLanes {
  Lanes columns[3], half;

  explicit BoxLanes(const CompactObb& box) {
    const auto* bytes = reinterpret_cast<const char*>(&box);
    static_assert(offsetof(CompactObb, half) == 9 * sizeof(float));
    for (int k = 0; k < 3; ++k) columns[k] = load_lanes<Lanes>(bytes + 3 * sizeof(float) * k);
    half = load_lanes<Lanes>(bytes + offsetof(CompactObb, half));
  }
};

/// v[1], v[2], v[0] and v[2], v[0], v[1].
Lanes next(Lanes v) {
  return __builtin_shufflevector(v, v, 1, 2, 0, 3);
}
Lanes after_next(Lanes v) {
  return __builtin_shufflevector(v, v, 2, 0, 1, 3);
}

/// Largest squared gap along axis i of a crossed with the axes of b; rows[i][j]: axis i along j.
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

BoxDistance::BoxDistance(const Pose& X_AB)
    : R_AB_(to_matrix(X_AB.q)), p_AB_(X_AB.p), rounding_(kRounding * norm(X_AB.p)) {
  for (int k = 0; k < 3; ++k) {
    const Vec3 column = R_AB_.column(k);
    columns_AB_[k] = Lanes{static_cast<float>(column.x), static_cast<float>(column.y),
                           static_cast<float>(column.z), 0};
  }
}

double BoxDistance::at_least(const CompactObb& a, const CompactObb& b) const {
  const auto centre = [](const CompactObb& box) -> Vec3 {
    return {box.centre_O[0], box.centre_O[1], box.centre_O[2]};
  };
  const Vec3 way = p_AB_ + R_AB_ * centre(b) - centre(a);
  const BoxLanes box_a(a), box_b(b);
  const Lanes h = box_a.half, g = box_b.half;
  const Lanes t = box_a.columns[0] * everywhere(static_cast<float>(way.x)) +
                  box_a.columns[1] * everywhere(static_cast<float>(way.y)) +
                  box_a.columns[2] * everywhere(static_cast<float>(way.z));
  // columns of b's axes along a's: r[j][i]
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
  const Lanes gap_a = positive(magnitude(t) - h - reach_b);
  const Lanes gap_b = positive(magnitude(turned(rows, t)) - g - reach_a);
  const float faces = std::max(sum(gap_a * gap_a), sum(gap_b * gap_b));
  const Lanes c0 = gap2_across<0>(t, h, g, rows), c1 = gap2_across<1>(t, h, g, rows),
              c2 = gap2_across<2>(t, h, g, rows);
  Lanes across = c0 > c1 ? c0 : c1;
  across = across > c2 ? across : c2;
  const float gap2 = std::max({faces, across[0], across[1], across[2]});
  const double size = static_cast<double>(kSlack * (sum(h) + sum(g)));
  const double places = kRounding * (norm(centre(a)) + norm(centre(b))) + rounding_;
  const double gap = (1 - static_cast<double>(kSlack)) * std::sqrt(static_cast<double>(gap2));
  return std::max(gap - size - places, 0.0);
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "contact/query/triangle/triangles_meet.h"
#include "proto/math/assert.h"

namespace haptic {

/// Pairs of triangles in structure-of-arrays layout.
struct DistanceBatch {
  static constexpr size_t kRoom = 64;
  using Lanes = std::array<double, kRoom>;
  size_t n = 0;
  std::array<Lanes, 9> a{}, b{};  // corners, coordinate by coordinate, those of b in B
  // results; the corners of b are then in A. `way` goes from a to b, in A; `gap` is the distance,
  // times |way|, of the planes normal to it through both triangles
  Lanes distance_squared{}, gap{}, parts{}, along_a{}, along_b{};
  std::array<Lanes, 3> way{};

  /// There must be room.
  void add(const Corners& corners_A, const Corners& corners_B);
  Corners corners_a(size_t i) const;
  Corners corners_b(size_t i) const;
};

inline void DistanceBatch::add(const Corners& corners_A, const Corners& corners_B) {
  HAPTIC_ASSERT(n < kRoom);
  for (size_t k = 0; k < 3; ++k) {
    a[3 * k][n] = corners_A[k].x, a[3 * k + 1][n] = corners_A[k].y,
          a[3 * k + 2][n] = corners_A[k].z;
    b[3 * k][n] = corners_B[k].x, b[3 * k + 1][n] = corners_B[k].y,
          b[3 * k + 2][n] = corners_B[k].z;
  }
  ++n;
}

inline Corners DistanceBatch::corners_a(size_t i) const {
  return {{{a[0][i], a[1][i], a[2][i]}, {a[3][i], a[4][i], a[5][i]}, {a[6][i], a[7][i], a[8][i]}}};
}

inline Corners DistanceBatch::corners_b(size_t i) const {
  return {{{b[0][i], b[1][i], b[2][i]}, {b[3][i], b[4][i], b[5][i]}, {b[6][i], b[7][i], b[8][i]}}};
}

}  // namespace haptic

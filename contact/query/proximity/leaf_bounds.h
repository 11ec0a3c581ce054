// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/query/proximity/sliding_planes.h"
#include "contact/shape/tree/obb_tree.h"

namespace haptic {

/// Lower bounds of the distances between the triangles of a leaf of A and those of a leaf of B: for
/// triangle i of A and j of B, at 4 j + i, the gap along a fixed separating direction in A. A
/// motion of b along the direction changes the gap; motion across it does not.
struct alignas(64) LeafBounds {
  static constexpr size_t kPairs = kLeafTriangles * kLeafTriangles;

  std::array<float, kPairs> at_least;              // [m]; infinite where there are no triangles
  std::array<std::array<int16_t, kPairs>, 3> way;  // unit directions in A, in steps of 1/32767
  std::array<float, 3> centre_B;                   // bounding ball of b
  float radius;                                    // [m]
  float rounding;  // error of a gap through the rounding of its direction [m]
  uint32_t pair;   // index of the leaf pair in the front
  uint16_t asked;  // bit k: triangle pair k must be measured

  /// For leaves with n_a and n_b triangles and boxes of these half diagonals [m]: all bounds 0, all
  /// to be measured.
  void begin(size_t n_a, size_t n_b, double half_a, double half_b);
  void set_ball(const Vec3& centre, double most);
  /// Stores a measurement: a unit direction from a to b, and the gap along it [m]; 0 where they
  /// meet.
  void set(size_t k, const Vec3& unit_A, double gap);

  size_t nearest() const;
  Vec3 way_A(size_t k) const;  // not normalised
};
static_assert(sizeof(LeafBounds) == 192);

/// Moves all bounds along with B. Marks the triangle pairs to be measured, whose gap is at most
/// `least` [m] now or was at most `before`, and appends their leaf pairs to `asked`.
void move_along(std::vector<LeafBounds>& bounds, const PoseChange& change, double least,
                double before, std::vector<uint32_t>& asked);

}  // namespace haptic

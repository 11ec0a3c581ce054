// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "contact/query/proximity/sliding_planes.h"
#include "contact/shape/tree/obb_tree.h"

namespace haptic {

/// How far the triangles of a leaf of A are apart from those of a leaf of B, at least: of triangle
/// i of A and j of B, at 4 j + i, along a direction in A across which planes keep them apart. Where
/// b goes along it is gained or lost; what it does across counts for nothing.
struct alignas(64) LeafBounds {
  static constexpr size_t kPairs = kLeafTriangles * kLeafTriangles;

  std::array<float, kPairs> at_least;              // [m]; infinite where there are no triangles
  std::array<std::array<int16_t, kPairs>, 3> way;  // unit vectors in steps
  std::array<float, 3> centre_B;                   // of a ball around b
  float radius;                                    // [m]
  float rounding;                                  // of a gap [m]
  uint32_t pair;                                   // whose they are
  uint16_t asked;                                  // a bit for each that is to be measured

  /// Of leaves of these half diagonals: nothing is known but how many triangles there are, and all
  /// are to be measured.
  void begin(size_t n_a, size_t n_b, double half_a, double half_b);
  void set_ball(const Vec3& centre, double most);
  /// Sets what was measured: a unit vector from a to b, and how far both are apart along it [m]; 0
  /// where they meet.
  void set(size_t k, const Vec3& unit_A, double gap);

  size_t nearest() const;
  Vec3 way_A(size_t k) const;  // of any length
};
static_assert(sizeof(LeafBounds) == 192);

/// Moves all along with B. Asks for those pairs of triangles that are no more than `least` [m]
/// apart now, or were no more than `before`; appends the pairs of leaves that have any.
void move_along(std::vector<LeafBounds>& bounds, const PoseChange& change, double least,
                double before, std::vector<uint32_t>& asked);

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/proximity/leaf_bounds.h"

#include <algorithm>
#include <span>

#include "contact/query/point/patch_lanes.h"
#include "contact/query/simd/lanes8.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr double kFloats = 1e-6;         // relative error of a ball in float
constexpr float kWayStep = 1 / 32767.F;  // of the components of a direction
// errors of a gap from the rounding of its direction to steps: relative, and in half diagonals of
// both boxes
constexpr float kWayError = 1e-4F;
constexpr double kWayRounding = 2e-4;

using Short8 [[gnu::vector_size(16)]] = int16_t;

/// Moves the bounds of one leaf pair, and marks the triangles to be measured.
HAPTIC_INLINE void move_one(LeafBounds& bounds, const MovedFloats& moved, float least,
                            float before) {
  const std::array<float, 3>& c = bounds.centre_B;
  const Lanes way = kWayStep * moved.of(c[0], c[1], c[2]);
  const float lost = moved.angle * bounds.radius + moved.rounding;
  uint32_t asked = 0;
#pragma GCC unroll 2
  for (size_t k = 0; k < LeafBounds::kPairs; k += 8) {
    Float8 was;
    std::memcpy(&was, &bounds.at_least[k], sizeof was);
    Float8 is = (1 - 4 * lanes8::kUlp) * was - lost;
#pragma GCC unroll 3
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto steps = load_lanes<Short8>(&bounds.way[axis][k]);
      is += way[axis] * __builtin_convertvector(steps, Float8);
    }
    std::memcpy(&bounds.at_least[k], &is, sizeof is);
    // not-a-number is measured, too
    asked |= lanes8::lanes_of(~((is > least) & (was > before))).bits() << k;
  }
  bounds.asked = static_cast<uint16_t>(asked);
}

HAPTIC_WIDE void move_all(std::span<LeafBounds> bounds, const MovedFloats& moved, float least,
                          float before) {
  for (LeafBounds& leaf : bounds) move_one(leaf, moved, least, before);
}

}  // namespace

void LeafBounds::begin(size_t n_a, size_t n_b, double half_a, double half_b) {
  HAPTIC_ASSERT(n_a <= kLeafTriangles && n_b <= kLeafTriangles);
  at_least.fill(lanes8::kInfinity);
  way = {};
  asked = 0;
  for (size_t j = 0; j < n_b; ++j) {
    for (size_t i = 0; i < n_a; ++i) {
      const size_t k = kLeafTriangles * j + i;
      at_least[k] = 0;
      asked = static_cast<uint16_t>(asked | 1u << k);
    }
  }
  rounding = static_cast<float>(kWayRounding * (half_a + half_b));
}

void LeafBounds::set_ball(const Vec3& centre, double most) {
  HAPTIC_ASSERT(most >= 0);
  centre_B = to_floats(centre);
  radius = static_cast<float>((1 + kFloats) * most + kFloats * norm(centre));
}

void LeafBounds::set(size_t k, const Vec3& unit_A, double gap) {
  const std::array<float, 3> w = to_floats(unit_A);
  for (size_t axis = 0; axis < 3; ++axis) way[axis][k] = static_cast<int16_t>(w[axis] / kWayStep);
  at_least[k] = (1 - kWayError) * std::max(static_cast<float>(gap), 0.F) - rounding;
}

size_t LeafBounds::nearest() const {
  return static_cast<size_t>(std::min_element(at_least.begin(), at_least.end()) - at_least.begin());
}

Vec3 LeafBounds::way_A(size_t k) const {
  return {static_cast<double>(way[0][k]), static_cast<double>(way[1][k]),
          static_cast<double>(way[2][k])};
}

void move_along(std::vector<LeafBounds>& bounds, const PoseChange& change, double least,
                double before, std::vector<uint32_t>& asked) {
  constexpr size_t kAtOnce = 64;  // records that fit in the L1 cache
  const MovedFloats moved(change);
  const float bound = round_up_distance(least), bound_before = round_up_distance(before);
  for (size_t first = 0; first < bounds.size(); first += kAtOnce) {
    const std::span<LeafBounds> some =
        std::span(bounds).subspan(first, std::min(kAtOnce, bounds.size() - first));
    move_all(some, moved, bound, bound_before);
    for (const LeafBounds& leaf : some) {
      if (leaf.asked != 0) asked.push_back(leaf.pair);
    }
  }
}

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "contact/query/simd/lanes8.h"
#include "proto/math/vec3.h"

namespace haptic {

/// Which points of a patch are searched: any; local minima of the distance; local minima seen from
/// the front.
enum class Facing { kAny, kEitherSide, kFront };

/// A point prepared for the tests, in float with conservative rounding.
struct PatchProbe {
  explicit PatchProbe(const Vec3& p) : p_O(p) {
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<size_t>(k);
      const auto x = static_cast<float>(p[k]);
      const float ulp = lanes8::kUlp * (x < 0 ? -x : x);
      at[row] = x, below[row] = x - ulp, above[row] = x + ulp;
      slack += 4 * ulp;  // a rounding of p, one of the product, two of the sum
    }
  }

  Vec3 p_O;
  std::array<float, 3> below, above, at;
  float slack = 0;  // of axis·p
};

/// A float no less than the distance.
inline float round_up_distance(double distance) {
  return static_cast<float>(distance) * (1 + lanes8::kUlp) + 1e-18F;
}

/// Limit for squared distances of patches, rounded up.
inline float limit_squared(float limit) {
  constexpr float kSumError = 1e-5F;
  return limit * limit * (1 + kSumError);
}

}  // namespace haptic

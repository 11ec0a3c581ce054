// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>
#include <limits>

#include "contact/shape/patch_tree.h"

namespace haptic {

/// Which points of a patch are asked for: any, those locally nearest to the point, or of these
/// those that have it in front.
enum class Facing { kAny, kEitherSide, kFront };

/// A point held against four patches at once, in float rounded the safe way.
class PatchProbe {
 public:
  using Float4 __attribute__((vector_size(16))) = float;
  using Int4 __attribute__((vector_size(16))) = int32_t;

  explicit PatchProbe(const Vec3& p_O) {
    for (int k = 0; k < 3; ++k) {
      const auto near = static_cast<float>(p_O[k]);
      // a whole rounding to either side, whichever way this one went
      const float ulp = kUlp * (near < 0 ? -near : near);
      below_[k] = splat(near - ulp), above_[k] = splat(near + ulp), at_[k] = splat(near);
      slack_ += 4 * ulp;  // of axis·p: a rounding of p, one of the product, two of the sum
    }
  }

  struct Bounds {
    Float4 distance_squared;  // to anything in the patch, at least
    Int4 kept;                // lanes that may hold such a point: all bits set
  };

  /// Patches no further than the root of limit that may hold a point asked for.
  template <Facing facing>
  Bounds bounds(const PatchNode& node, float limit) const {
    Float4 box = splat(0), along = splat(0);
    for (size_t k = 0; k < 3; ++k) {
      const Float4 outside = larger(
          larger(load(node.lower[k]) - above_[k], below_[k] - load(node.upper[k])), splat(0));
      box += outside * outside;
      along += load(node.axis[k]) * at_[k];
    }
    // how far the point is in front of the lowest of the slab, and behind the highest
    const Float4 front = along - load(node.low) + slack_, back = load(node.high) - along + slack_;
    const Float4 gap = larger(larger(-front, -back), splat(0));
    const Float4 lower_bound = larger(box, gap * gap);
    const Int4 too_far = lower_bound > splat(limit);
    if constexpr (facing == Facing::kAny) return {lower_bound, ~too_far};
    const Float4 cos_squared = load(node.cos_squared);
    Float4 above = larger(front, back);
    if constexpr (facing == Facing::kFront) {
      // beyond 45° a pit seen from behind may count as seen from the front
      above = cos_squared > 0.5F ? larger(front, splat(0)) : above;
    }
    return {lower_bound, ~(too_far | (above * above < cos_squared * lower_bound))};
  }

  /// A limit for `bounds` that keeps whatever is no further than the root of distance_squared.
  static float limit(double distance_squared) {
    return static_cast<float>(distance_squared) * (1 + 1e-5F) + 1e-37F;
  }

 private:
  static constexpr float kUlp = 1.2e-7F;

  static Float4 splat(float x) { return Float4{x, x, x, x}; }
  static Float4 load(const PatchNode::Lanes& lanes) {
    Float4 v;
    std::memcpy(&v, lanes.data(), sizeof v);
    return v;
  }
  static Float4 larger(Float4 a, Float4 b) { return a > b ? a : b; }

  Float4 below_[3], above_[3], at_[3];
  float slack_ = 0;
};

}  // namespace haptic

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "contact/query/point/patch_probe.h"
#include "contact/query/simd/lane_set.h"
#include "contact/query/simd/lanes8.h"
#include "contact/shape/tree/patch_tree.h"

namespace haptic {
namespace lanes8 {

/// A point in quantisation steps of the leaf, relative to its origin, broadcast to eight lanes.
HAPTIC_INLINE Vec8 in_steps(const PatchLeaf& leaf, const Vec3& p_O) {
  const float per_step = 1 / leaf.step;
  const auto from_origin = [&](int k) {
    const auto origin = static_cast<double>(leaf.origin[static_cast<size_t>(k)]);
    return splat(per_step * static_cast<float>(p_O[k] - origin));
  };
  return {from_origin(0), from_origin(1), from_origin(2)};
}

/// Corner i of each triangle, in the same steps.
HAPTIC_INLINE Vec8 corner(const PatchLeaf& leaf, size_t i) {
  const Int8 word = load<Int8>(leaf.corners[i]);
  return {__builtin_convertvector(word & 1023, Float8),
          __builtin_convertvector((word >> 10) & 1023, Float8),
          __builtin_convertvector(word >> 20, Float8)};
}

}  // namespace lanes8

/// patches_near, inlined into functions compiled for AVX2.
HAPTIC_INLINE LaneSet patches_near(const PatchNode& node, const PatchProbe& probe,
                                   float limit_squared, Facing facing, Float8& distance_squared) {
  using namespace lanes8;
  Float8 box = splat(0), along = splat(0);
#pragma GCC unroll 3
  for (size_t k = 0; k < 3; ++k) {
    const Float8 before = load<Float8>(node.lower[k]) - splat(probe.above[k]);
    const Float8 behind = splat(probe.below[k]) - load<Float8>(node.upper[k]);
    const Float8 outside = larger(larger(before, behind), splat(0));
    box += outside * outside;
    along += load<Float8>(node.axis[k]) * splat(probe.at[k]);
  }
  // distance in front of the lowest plane of the slab, and behind the highest
  const Float8 slack = splat(probe.slack);
  const Float8 front = along - load<Float8>(node.low) + slack;
  const Float8 back = load<Float8>(node.high) - along + slack;
  const Float8 outside_slab = smaller(smaller(front, back), splat(0));
  distance_squared = larger(box, outside_slab * outside_slab);

  Int8 dropped = distance_squared > splat(limit_squared);
  if (facing != Facing::kAny) {
    const Float8 cos_squared = load<Float8>(node.cos_squared);
    Float8 above = larger(front, back);
    if (facing == Facing::kFront) {
      // in cones beyond 45° a pit seen from behind may count as seen from the front
      above = cos_squared > splat(0.5F) ? larger(front, splat(0)) : above;
    }
    dropped |= above * above < cos_squared * distance_squared;
  }
  return lanes_of(~dropped);
}

/// Lower and upper bounds of the distances to the triangles of a leaf [m].
HAPTIC_INLINE void bound_triangles(const PatchLeaf& leaf, const PatchProbe& probe, Float8& at_least,
                                   Float8& at_most) {
  using namespace lanes8;
  const Vec8 p = in_steps(leaf, probe.p_O);
  // |p − a − s ab − t ac|² is quadratic in (s, t): its minimum is in the face or on a side
  const Vec8 a = corner(leaf, 0);
  const Vec8 ab = corner(leaf, 1) - a, ac = corner(leaf, 2) - a, pa = a - p;
  const Float8 bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac);
  const Float8 pb = dot(ab, pa), pc = dot(ac, pa), pp = dot(pa, pa);
  const Float8 det = bb * cc - bc * bc;
  const Float8 s = bc * pc - cc * pb, t = bc * pb - bb * pc;
  const Int8 above_face = (s >= splat(0)) & (t >= splat(0)) & (s + t <= det);
  const Float8 to_face = pp + (pb * s + pc * t) / det;
  const Float8 across = bb - 2 * bc + cc;
  const Float8 to_sides = smaller(smaller(least_along(pp, pb, bb), least_along(pp, pc, cc)),
                                  least_along(pp + 2 * pb + bb, bc - bb + pc - pb, across));
  const Float8 d = above_face ? to_face : to_sides;
  const Float8 error = kCancelled * (pp + bb + cc);

  const Int8 is_thin = ~(det > splat(0));
  const Int8 is_empty = load<Int8>(leaf.triangle) == -1;
  const Float8 nearest = square_root(larger(d - error, splat(0)));
  const Float8 furthest = square_root(larger(d + error, splat(0)));
  at_least = (nearest - splat(kError)) * splat(leaf.step * (1 - kSumError));
  at_most = (furthest + splat(kError)) * splat(leaf.step * (1 + kSumError));
  at_least = is_thin ? splat(0) : at_least;
  at_most = is_empty | is_thin ? splat(kInfinity) : at_most;
}

/// Triangles that may be within `limit`; not-a-number counts as near.
HAPTIC_INLINE LaneSet lanes_near(const PatchLeaf& leaf, Float8 at_least, float limit) {
  using namespace lanes8;
  return lanes_of(~(at_least > splat(limit)) & (load<Int8>(leaf.triangle) != -1));
}

}  // namespace haptic

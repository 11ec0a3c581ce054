// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>
#include <limits>

#include "contact/query/point/patch_tests.h"

// twice the width where the processor has it; sanitizers do not stand the choice at load time
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HAPTIC_WIDE __attribute__((target_clones("avx2", "default"), flatten))
#else
#define HAPTIC_WIDE
#endif
#define HAPTIC_INLINE __attribute__((always_inline)) inline

// the lanes are never passed: all that takes them is inlined
#pragma GCC diagnostic ignored "-Wpsabi"

namespace haptic {

using Float8 [[gnu::vector_size(32)]] = float;
using Int8 [[gnu::vector_size(32)]] = int32_t;

namespace lanes8 {

inline constexpr float kSumError = 1e-5F;  // of a sum of squares
inline constexpr float kError = 2;         // steps: one of the leaf, and the roundings of the point
// of the longest vector in play, squared: what the products of a triangle cancel, not too thin
inline constexpr float kCancelled = 5e-5F;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

HAPTIC_INLINE Float8 splat(float x) {
  // by way of integers, of which g++ 12 makes one instruction
  int32_t i;
  std::memcpy(&i, &x, sizeof i);
  const Int8 bits{i, i, i, i, i, i, i, i};
  Float8 v;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

template <class Vector, class Lanes>
HAPTIC_INLINE Vector load(const Lanes& lanes) {
  Vector v;
  static_assert(sizeof v == sizeof lanes);
  std::memcpy(&v, lanes.data(), sizeof v);
  return v;
}

HAPTIC_INLINE Float8 larger(Float8 a, Float8 b) {
  return a > b ? a : b;
}
HAPTIC_INLINE Float8 smaller(Float8 a, Float8 b) {
  return a < b ? a : b;
}

HAPTIC_INLINE float least(Float8 v) {
  v = smaller(v, __builtin_shuffle(v, Int8{4, 5, 6, 7, 0, 1, 2, 3}));
  v = smaller(v, __builtin_shuffle(v, Int8{2, 3, 0, 1, 6, 7, 4, 5}));
  v = smaller(v, __builtin_shuffle(v, Int8{1, 0, 3, 2, 5, 4, 7, 6}));
  return v[0];
}

using Float4 [[gnu::vector_size(16)]] = float;
HAPTIC_INLINE Float4 low_half(Float8 v) {
  return __builtin_shufflevector(v, v, 0, 1, 2, 3);
}
HAPTIC_INLINE Float4 high_half(Float8 v) {
  return __builtin_shufflevector(v, v, 4, 5, 6, 7);
}

HAPTIC_INLINE LaneSet lanes_of(Int8 mask) {
#if defined(__SSE2__)
  Float8 bits;
  std::memcpy(&bits, &mask, sizeof bits);
  const int low = __builtin_ia32_movmskps(low_half(bits));
  const int high = __builtin_ia32_movmskps(high_half(bits));
  return LaneSet(static_cast<uint32_t>(low | high << 4));
#else
  Int8 v = mask & Int8{1, 2, 4, 8, 16, 32, 64, 128};
  v |= __builtin_shuffle(v, Int8{4, 5, 6, 7, 0, 1, 2, 3});
  v |= __builtin_shuffle(v, Int8{2, 3, 0, 1, 6, 7, 4, 5});
  return LaneSet(static_cast<uint32_t>(v[0] | v[1]));
#endif
}

HAPTIC_INLINE Float8 square_root(Float8 v) {
#if defined(__SSE2__)
  const Float4 low = __builtin_ia32_sqrtps(low_half(v)), high = __builtin_ia32_sqrtps(high_half(v));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  for (int i = 0; i < 8; ++i) v[i] = __builtin_sqrtf(v[i]);
  return v;
#endif
}

struct Vec8 {
  Float8 x, y, z;
};
HAPTIC_INLINE Vec8 operator-(const Vec8& a, const Vec8& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HAPTIC_INLINE Float8 dot(const Vec8& a, const Vec8& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

HAPTIC_INLINE Vec8 operator+(const Vec8& a, const Vec8& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HAPTIC_INLINE Vec8 operator*(Float8 s, const Vec8& v) {
  return {s * v.x, s * v.y, s * v.z};
}

/// A point in steps of the leaf from its origin, eight times.
HAPTIC_INLINE Vec8 in_steps(const PatchLeaf& leaf, const Vec3& p_O) {
  const float per_step = 1 / leaf.step;
  const auto from_origin = [&](int k) {
    const auto origin = static_cast<double>(leaf.origin[static_cast<size_t>(k)]);
    return splat(per_step * static_cast<float>(p_O[k] - origin));
  };
  return {from_origin(0), from_origin(1), from_origin(2)};
}

/// A corner of each triangle, in the same steps.
HAPTIC_INLINE Vec8 corner(const PatchLeaf& leaf, size_t i) {
  const Int8 word = load<Int8>(leaf.corners[i]);
  return {__builtin_convertvector(word & 1023, Float8),
          __builtin_convertvector((word >> 10) & 1023, Float8),
          __builtin_convertvector(word >> 20, Float8)};
}

/// Where along start + 2 slope u + curvature u² it is least, for u in [0, 1].
HAPTIC_INLINE Float8 least_at(Float8 slope, Float8 curvature) {
  return smaller(larger(-slope / curvature, splat(0)), splat(1));
}

/// How much that is: a squared distance along a side.
HAPTIC_INLINE Float8 least_along(Float8 start, Float8 slope, Float8 curvature) {
  const Float8 u = least_at(slope, curvature);
  return start + u * (2 * slope + curvature * u);
}

}  // namespace lanes8

/// patches_near, to be inlined where the lanes are wide.
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
  // how far the point is in front of the lowest of the slab, and behind the highest
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
      // beyond 45° a pit seen from behind may count as seen from the front
      above = cos_squared > splat(0.5F) ? larger(front, splat(0)) : above;
    }
    dropped |= above * above < cos_squared * distance_squared;
  }
  return lanes_of(~dropped);
}

/// Between what and what the triangles of a leaf are away [m].
HAPTIC_INLINE void bound_triangles(const PatchLeaf& leaf, const PatchProbe& probe, Float8& at_least,
                                   Float8& at_most) {
  using namespace lanes8;
  const Vec8 p = in_steps(leaf, probe.p_O);
  // |p − a − s ab − t ac|² is a quadratic in (s, t): least inside the triangle or on a side
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

/// Those that may be no further than `limit`: what is not a number stays.
HAPTIC_INLINE LaneSet lanes_near(const PatchLeaf& leaf, Float8 at_least, float limit) {
  using namespace lanes8;
  return lanes_of(~(at_least > splat(limit)) & (load<Int8>(leaf.triangle) != -1));
}

}  // namespace haptic

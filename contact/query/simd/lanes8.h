// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>
#include <limits>

#include "contact/query/simd/lane_set.h"

// 256-bit code where the processor has AVX2; sanitizers cannot handle function multiversioning
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define HAPTIC_WIDE __attribute__((target_clones("avx2", "default"), flatten))
#else
#define HAPTIC_WIDE
#endif
#define HAPTIC_INLINE __attribute__((always_inline)) inline

// vectors are never passed in calls: all functions that take them are inlined
#pragma GCC diagnostic ignored "-Wpsabi"

namespace haptic {

using Float8 [[gnu::vector_size(32)]] = float;
using Int8 [[gnu::vector_size(32)]] = int32_t;

namespace lanes8 {

inline constexpr float kSumError = 1e-5F;  // relative error of a sum of squares
inline constexpr float kError = 2;  // error of a distance, in quantisation steps of the leaf: one
                                    // of the leaf, one for rounding the point
// cancellation error of the triangle formulas, relative to the largest squared length, unless too
// thin
inline constexpr float kCancelled = 5e-5F;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kUlp = 1.2e-7F;  // an ulp of 1

HAPTIC_INLINE Float8 splat(float x) {
  // via integers, which g++ 12 compiles to one instruction
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

/// u in [0, 1] that minimises start + 2 slope u + curvature u².
HAPTIC_INLINE Float8 least_at(Float8 slope, Float8 curvature) {
  return smaller(larger(-slope / curvature, splat(0)), splat(1));
}

/// The minimum itself: a squared distance to a side.
HAPTIC_INLINE Float8 least_along(Float8 start, Float8 slope, Float8 curvature) {
  const Float8 u = least_at(slope, curvature);
  return start + u * (2 * slope + curvature * u);
}

}  // namespace lanes8

}  // namespace haptic

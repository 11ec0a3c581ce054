// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "proto/math/vec3.h"

namespace haptic {

/// 128-bit vectors: two doubles, four floats or integers, eight or sixteen small integers. A
/// comparison gives −1 for true in each lane.
using Pair [[gnu::vector_size(16)]] = double;
using Lanes [[gnu::vector_size(16)]] = float;
using IntLanes [[gnu::vector_size(16)]] = int32_t;
using ShortLanes [[gnu::vector_size(16)]] = int16_t;
using ByteLanes [[gnu::vector_size(16)]] = int8_t;

/// Loads from memory, or reinterprets the bits of another vector.
template <class V>
V load_lanes(const void* p) {
  V v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

/// The fourth lane is 0.
inline Lanes to_lanes(const Vec3& v) {
  return Lanes{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0};
}

inline Lanes magnitude(Lanes v) {
  const IntLanes bits = load_lanes<IntLanes>(&v) & 0x7fffffff;
  return load_lanes<Lanes>(&bits);
}

/// Each of the first eight bytes doubled into a 16-bit integer; doubled_high: the last eight.
inline ShortLanes doubled_low(ByteLanes v) {
  const ByteLanes twice =
      __builtin_shufflevector(v, v, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7);
  return load_lanes<ShortLanes>(&twice);
}
inline ShortLanes doubled_high(ByteLanes v) {
  const ByteLanes twice =
      __builtin_shufflevector(v, v, 8, 8, 9, 9, 10, 10, 11, 11, 12, 12, 13, 13, 14, 14, 15, 15);
  return load_lanes<ShortLanes>(&twice);
}

/// Bit 2 i: lane i is true.
inline unsigned bits_of(ShortLanes answers) {
#if defined(__SSE2__)
  using Bytes [[gnu::vector_size(16)]] = char;
  return static_cast<unsigned>(__builtin_ia32_pmovmskb128(load_lanes<Bytes>(&answers))) & 0x5555;
#else
  unsigned bits = 0;
  for (int i = 0; i < 8; ++i) bits |= answers[i] != 0 ? 1u << (2 * i) : 0;
  return bits;
#endif
}

}  // namespace haptic

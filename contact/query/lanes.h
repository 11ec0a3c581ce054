// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <cstring>

namespace haptic {

/// Four floats, eight small integers: what one instruction computes at a time. A comparison answers
/// −1 for yes in each lane.
using Lanes [[gnu::vector_size(16)]] = float;
using LaneMask [[gnu::vector_size(16)]] = int;
using ShortLanes [[gnu::vector_size(16)]] = int16_t;
using ByteLanes [[gnu::vector_size(8)]] = int8_t;

template <class V>
V load_lanes(const void* p) {
  V v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

inline ShortLanes load_widened(const void* p) {
  return __builtin_convertvector(load_lanes<ByteLanes>(p), ShortLanes);
}

inline Lanes magnitude(Lanes v) {
  const LaneMask bits = load_lanes<LaneMask>(&v) & 0x7fffffff;
  return load_lanes<Lanes>(&bits);
}

}  // namespace haptic

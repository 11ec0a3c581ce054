// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>

namespace haptic {

/// Four floats, and four answers (−1: yes): what one instruction computes at a time.
using Lanes [[gnu::vector_size(16)]] = float;
using LaneMask [[gnu::vector_size(16)]] = int;

inline Lanes load_lanes(const float* p) {
  Lanes v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

inline Lanes magnitude(Lanes v) {
  LaneMask bits;
  std::memcpy(&bits, &v, sizeof v);
  bits &= 0x7fffffff;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

/// Bit i: answer i.
inline unsigned bits_of(LaneMask m) {
  m &= LaneMask{1, 2, 4, 8};
  m |= __builtin_shufflevector(m, m, 2, 3, 0, 1);
  m |= __builtin_shufflevector(m, m, 1, 0, 3, 2);
  return static_cast<unsigned>(m[0]);
}

}  // namespace haptic

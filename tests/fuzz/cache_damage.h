// SPDX-License-Identifier: GPL-3.0-or-later
// Blocks of the cache, damaged in ways that its readers must notice or survive.
#pragma once

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "contact/shape/baked/block.h"
#include "proto/math/vec3.h"
#include "tests/fuzz/fuzz_meter.h"

namespace haptic::test::cache_damage {

using Bytes = std::vector<std::byte>;
using Random = FuzzMeter::Random;

inline constexpr uint64_t kKey = 7;

/// A number at an edge of its type or of the arrays, or a random one.
inline uint64_t odd_number(Random& random) {
  static constexpr uint64_t kNumbers[] = {0,
                                          1,
                                          0x7fffffff,
                                          0x80000000,
                                          0xffffffff,
                                          0x7f800000,
                                          0x7fc00000,
                                          0x7ff0000000000000,
                                          0x7ff8000000000000,
                                          0x3ff0000000000000,
                                          0x7fefffffffffffff,
                                          0xffffffffffffffff};
  switch (random() % 3) {
    case 0:
      return kNumbers[random() % std::size(kNumbers)];
    case 1:
      return random() % 1000;
    default:
      return random();
  }
}

inline void damage(Bytes& array, Random& random) {
  if (array.empty() || random() % 16 == 0) {
    array.resize(random() % (array.size() + 64) / 8 * 8);
    return;
  }
  const size_t size = std::min(array.size(), size_t{1} << random() % 4);
  const size_t at = random() % (array.size() / size) * size;
  const uint64_t number = odd_number(random);
  std::memcpy(array.data() + at, &number, size);
}

/// The block with a few numbers changed and the checksum corrected.
inline Bytes damaged_inside(const Bytes& good, BakedKind kind, size_t n_arrays, Random& random) {
  const BakedBlock block = view_block(good, kind, kKey, n_arrays);
  std::vector<Bytes> arrays;
  for (size_t i = 0; i < n_arrays; ++i) {
    arrays.emplace_back(block.arrays[i].begin(), block.arrays[i].end());
  }
  for (uint64_t n = 1 + random() % 4; n > 0; --n) damage(arrays[random() % n_arrays], random);
  std::vector<std::span<const std::byte>> views(arrays.begin(), arrays.end());
  return write_block(kind, kKey, views);
}

/// The file damaged, cut or extended; never unchanged.
inline Bytes damaged_outside(const Bytes& good, Random& random) {
  for (;;) {
    Bytes bytes = good;
    if (random() % 4 == 0) bytes.resize(random() % (good.size() + 100));
    for (uint64_t n = random() % 4; n > 0 && !bytes.empty(); --n) {
      // the header more often than the arrays
      const size_t range = random() % 2 == 0 ? std::min<size_t>(bytes.size(), 512) : bytes.size();
      bytes[random() % range] = static_cast<std::byte>(random());
    }
    if (bytes != good) return bytes;
  }
}

inline Vec3 point_near(Random& random) {
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  return {u(random), u(random), u(random)};
}

}  // namespace haptic::test::cache_damage

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace haptic::test {

/// The random choices for one input, determined by seed and number.
class FuzzRandom {
 public:
  FuzzRandom(uint64_t seed, uint64_t input) : engine_(seed * 0x9E3779B97F4A7C15u + input) {}

  uint64_t bits() { return engine_(); }
  size_t below(size_t n) { return static_cast<size_t>(engine_() % n); }
  template <typename T>
  const T& pick(const std::vector<T>& from) {
    return from[below(from.size())];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace haptic::test
